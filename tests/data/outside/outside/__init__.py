"""A package that knows remosplat_drake, which does not know it."""
