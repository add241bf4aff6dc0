"""Files of models, priors and pairs."""
