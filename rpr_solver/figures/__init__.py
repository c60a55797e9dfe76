"""Pictures of answers: documents in, scenes of simple shapes out, as SVG text with reproducible bytes.

Floats draw here and decide nothing: what a picture shows was proved before, in the document it is drawn from.
"""
