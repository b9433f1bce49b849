"""Results as files, pictures and objects of other packages, which are imported on demand."""
