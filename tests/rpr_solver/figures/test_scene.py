"""The roles of a scene are those of all its shapes."""

from rpr_solver.notebook.scene import Disc, Group, Paint, Path, Text, roles

LINE = [(0.0, 0.0), (1.0, 1.0)]


def test_roles_of_shapes_in_groups() -> None:
    shapes = (
        Group((Path((LINE,), Paint(stroke="curve")), Group((Disc((0, 0), 1, Paint("cusp", "ink")),)))),
        Text((0, 0), "A", role="soft", halo="paper"),
    )
    assert set(roles(shapes)) == {
        ("stroke", "curve"), ("fill", "cusp"), ("stroke", "ink"), ("fill", "soft"), ("stroke", "paper"),
    }  # fmt: skip
