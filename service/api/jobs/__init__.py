"""Jobs and batches as their callers see them: state, events, callbacks."""
