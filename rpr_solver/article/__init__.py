"""The article's own algorithm, step by step, as an audit of the solver's."""

from rpr_solver.article.table import ArticleTable, article_document, article_table

__all__ = [
    "ArticleTable",
    "article_document",
    "article_table",
]
