"""One slice: the eliminant Q(u, L), its roots, and the cusps above them."""
