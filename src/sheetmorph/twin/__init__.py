"""The same sheet as a body of finite elements, for other people's solvers to check ours."""
