"""Design: geometries sought for what their cusps are to do, by censuses and their sensitivities."""
