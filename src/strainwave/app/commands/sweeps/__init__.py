"""`strainwave sweep`, over trajectories of the error equation or responses of the whole drive."""
