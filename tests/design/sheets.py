"""A square of two triangles in the text format, in millimetres."""

SHEET = """\
*shellNodes
0, -20, -10, 0
1, 20, -10, 0
2, 20, 10, 0
3, -20, 10, 0
*FaceNodes
0, 0, 1, 2
1, 0, 2, 3
*Edges
0, 0, 1
1, 1, 2
2, 2, 3
3, 3, 0
4, 2, 0
"""
