-- Keeps a document, the first of several.
-- include: keep
-- keys: document
-- args: json ttl

keep_result(document, json, ttl)
