"""Controllers compared in many scenes: trials, their metrics and tables."""
