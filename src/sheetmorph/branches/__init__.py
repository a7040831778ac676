"""Which other shapes a sheet may take, and how firmly it holds each."""
