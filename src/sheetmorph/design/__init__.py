"""The design file and what follows from it: regions, stiffnesses, thermal strains."""
