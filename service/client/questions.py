"""The questions that a client asks, in the words of the library; `questions.pyi` has their types."""

from service.client.words import FUNCTIONS, made

globals().update({name: made(name) for name in FUNCTIONS})
