"""Comparison of entity tags in `If-None-Match` (RFC 9110, 13.1.2)."""


def has_tag(wanted: str, tag: str) -> bool:
    """Return whether a list of tags, as in `If-None-Match`, contains one: weak or strong, or any by `*`.

    Examples
    --------
    >>> has_tag('"x", W/"y"', '"y"'), has_tag("*", '"y"'), has_tag('"x"', '"y"'), has_tag("", '"y"')
    (True, True, False, False)
    """
    return any(one.strip().removeprefix("W/") in {tag, "*"} for one in wanted.split(","))
