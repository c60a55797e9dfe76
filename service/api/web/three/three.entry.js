export {
  BufferAttribute, BufferGeometry, Camera, DoubleSide, GLSL3, InstancedBufferAttribute, InstancedBufferGeometry, Mesh, Points,
  RawShaderMaterial, Scene, ShapeUtils, Vector2, WebGLRenderer,
} from "three";
