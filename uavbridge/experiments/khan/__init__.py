"""Khan, Yanmaz and Rinner 2014, "Information merging in multi-UAV cooperative search"."""
