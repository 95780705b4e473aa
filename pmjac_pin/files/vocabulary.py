"""Vocabulary: which elements and attributes a format has, and what of a file was not read.

What a reader does not look for it would pass over in silence, a misspelt `<orgin>` like an element
that ties two bodies together. So every file is first held against the words of its format: what
looks like a misspelt one is an error, and what is not known at all is told. Words with a star are
known to have no bearing on the machine, and only what could tie bodies together is looked for in
them; those with an exclamation mark are known to have one, and are told though nobody reads them.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from xml.etree.ElementTree import Element

from pmjac_pin.errors import ModelFileError, quoted

_LONGEST_WORD = 60  # characters; a longer name is like none of them
_SHORTEST = 2  # of one letter any other is one slip away
_ALIKE = 0.8  # of difflib's ratio, for names that are more than one slip away
_MOST_TOLD = 10
_MOST_WORDS = 4
_NAMES_PLACE = "\0"  # where the names of a kind of thing go
_OF_XML = "{http://www.w3.org/"  # attributes of XML itself and of its schemas
_TIE_WORDS = re.compile(
    r"joint|loop|loop_joint|closed_loop|constraint|coupling|equality|connect|weld|tendon|gripper"
    r"|plugin|model|include|drake:\w*(joint|mimic|constraint|bushing|spring|damper)\w*"
)
_TIES_BY_NAME = re.compile(
    r"mimic\w*|(parent|child)_(link|model|joint)|(passive|gap)_joint|(follower|leader)(_joint)?"
)


@dataclass(frozen=True)
class Word:
    """What an element may hold.

    Attributes
    ----------
    attributes, children : frozenset of str
    unread, harmless : frozenset of str
        Further attributes and further children, which have no bearing on the machine.
    told : frozenset of str
        Children that have one, and that nobody reads.
    """

    attributes: frozenset[str] = frozenset()
    children: frozenset[str] = frozenset()
    unread: frozenset[str] = frozenset()
    harmless: frozenset[str] = frozenset()
    told: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Vocabulary:
    """The words of a format.

    Attributes
    ----------
    text : str
        One line an element, continued by indented ones: ``tag attributes : children``, where the
        last two may be left out; a tag as ``parent/tag`` is meant within that parent only. A star
        says that an attribute or child is known and not read, and ``drake:*`` all of a namespace;
        an exclamation mark that it ties bodies together, and is told.
        Children without a line of their own hold text alone.

    Examples
    --------
    >>> from xml.etree.ElementTree import fromstring
    >>> words = Vocabulary("robot name : link camera*")
    >>> words.unread(fromstring('<robot name="r"><camera of="any"/><spring k="1"/></robot>'))
    ("not read: <spring> in robot 'r'",)
    >>> words.unread(fromstring('<robot><lnik/></robot>'))
    Traceback (most recent call last):
        ...
    pmjac_pin.errors.ModelFileError: <robot> holds an unknown <lnik>; did you mean 'link'?
    """

    text: str

    @cached_property
    def words(self) -> Mapping[str, Word]:
        """What each element may hold, by its tag or by ``parent/tag``."""
        found = {}
        for line in re.sub(r"\n +", " ", self.text.strip()).splitlines():
            head, _, children = line.partition(" : ")
            tag, *attributes = head.split()
            found[tag] = _word(attributes, children.split())
        return found

    def unread(self, root: Element, *skipped: Element) -> tuple[str, ...]:
        """Return a sentence for each kind of thing in a file that its reader does not know.

        Parameters
        ----------
        root : Element
        *skipped : Element
            What was read though these words do not know it.

        Raises
        ------
        ModelFileError
            An element or an attribute that looks like a misspelt one.
        """
        passed = set(map(id, skipped))
        kinds: dict[str, dict[str, None]] = {}
        for what, name in self._strange(root, root.tag, passed):
            kinds.setdefault(what, {})[name] = None
        more = len(kinds) - _MOST_TOLD
        notes = [f"not read: {_said(*kind)}" for kind in list(kinds.items())[:_MOST_TOLD]]
        return (*notes, f"not read: {more} more kinds of things") if more > 0 else tuple(notes)

    def known(self, root: Element) -> Element:
        """Return a copy of a file that holds what its reader looks for, and nothing else.

        Examples
        --------
        >>> from xml.etree.ElementTree import fromstring, tostring
        >>> words = Vocabulary("robot name : link camera*")
        >>> tostring(words.known(fromstring('<robot name="r" k="1"><camera/><link/></robot>')))
        b'<robot name="r"><link /></robot>'
        """
        return self._known(root, root.tag)

    def _known(self, element: Element, path: str) -> Element:
        word = self._word(path)
        given = {key: value for key, value in element.attrib.items() if key in word.attributes}
        copy = Element(element.tag, given)
        for child in element:
            if child.tag in word.children:
                copy.append(self._known(child, f"{element.tag}/{child.tag}"))
        return copy

    def _strange(self, element: Element, path: str, passed: set[int]) -> Iterator[tuple[str, str]]:
        """Yield what an element and its children hold that nobody reads: its kind and its name."""
        word = self._word(path)
        for attribute in element.attrib:
            if attribute in word.attributes or attribute.startswith(_OF_XML):
                continue
            if not _is_known(spelt(attribute), word.unread):
                self._refuse_near(element, spelt(attribute), word.attributes, "attribute")
                yield f"attribute {quoted(spelt(attribute))} of {_called(element)}", ""
        for child in element:
            tag = spelt(child.tag)
            if id(child) in passed:
                continue
            within = f"{spelt(element.tag)}/{tag}"
            of_space = _is_known(tag, word.harmless) and not could_tie(child)
            if tag in word.harmless or of_space:
                yield from self._ties_within(child, within, passed)
                continue
            if tag in word.children:
                yield from self._strange(child, within, passed)
                continue
            if tag not in word.told:
                self._refuse_near(element, tag, word.children | word.told, "element")
            yield _kind_and_name(child, element)

    def _ties_within(
        self, element: Element, path: str, passed: set[int]
    ) -> Iterator[tuple[str, str]]:
        """Yield what could tie bodies together in an element that has no bearing itself."""
        harmless = self._word(path).harmless
        for child in element:
            tag = spelt(child.tag)
            if id(child) in passed:
                continue
            if tag not in harmless and could_tie(child):
                yield _kind_and_name(child, element)
            else:
                yield from self._ties_within(child, f"{spelt(element.tag)}/{tag}", passed)

    def _word(self, path: str) -> Word:
        return self.words.get(path) or self.words.get(path.rpartition("/")[2], Word())

    def _refuse_near(self, element: Element, name: str, known: frozenset[str], what: str) -> None:
        if (meant := spelt_like(name, known)) is None:
            return
        if what == "element":
            got = f"{_called(element)} holds an unknown <{quoted(name)[1:-1]}>"
        else:
            got = f"{_called(element)} has the unknown attribute {quoted(name)}"
        raise ModelFileError(f"{got}; did you mean {meant!r}?")


def could_tie(element: Element) -> bool:
    """Whether an element could tie bodies together, wherever it stands: by its tag.

    Most tie nothing where they hold a name or a value alone.

    Examples
    --------
    >>> from xml.etree.ElementTree import fromstring
    >>> could_tie(fromstring("<joint><parent>a</parent></joint>"))
    True
    >>> could_tie(fromstring("<joint>elbow</joint>"))
    False
    """
    tag = spelt(element.tag)
    if _TIES_BY_NAME.fullmatch(tag):
        return True
    name_alone = not len(element) and not element.attrib and (element.text or "").strip()
    return not name_alone and _TIE_WORDS.fullmatch(tag) is not None


@lru_cache(maxsize=10_000)
def spelt_like(name: str, known: frozenset[str]) -> str | None:
    """Return the known name that a name looks like, if there is one.

    Examples
    --------
    >>> known = frozenset({"origin", "axis", "xyz", "rpy"})
    >>> spelt_like("orgin", known), spelt_like("Axis", known)
    ('origin', 'axis')
    >>> spelt_like("xzy", known), spelt_like("colour", known)
    ('xyz', None)
    """
    if len(name) > _LONGEST_WORD:
        return None
    alike = [other for other in sorted(known) if _one_slip(name.lower(), other.lower())]
    return next(iter(alike or difflib.get_close_matches(name.lower(), known, 1, _ALIKE)), None)


def _one_slip(name: str, other: str) -> bool:
    """Whether one letter was left out, added or changed, or two neighbours swapped."""
    if abs(len(name) - len(other)) > 1 or min(len(name), len(other)) < _SHORTEST:
        return False
    start = next((k for k, (a, b) in enumerate(zip(name, other, strict=False)) if a != b), None)
    if start is None:
        return True
    one, two = name[start:], other[start:]
    swapped = one[:2] == two[1::-1] and one[2:] == two[2:]
    return swapped or one[1:] == two or one == two[1:] or one[1:] == two[1:]


def spelt(name: str) -> str:
    """Return the name of an element or attribute with a short prefix for its namespace.

    Examples
    --------
    >>> spelt("{http://drake.mit.edu}mimic"), spelt("joint")
    ('drake:mimic', 'joint')
    """
    if not name.startswith("{"):
        return name
    space, _, local = name[1:].rpartition("}")
    words = [word for word in re.findall(r"\w+", space) if word not in _NO_NAMES]
    return f"{'drake' if 'drake' in words else (words or ['other'])[-1]}:{local}"


_NO_NAMES = ("http", "https", "www", "uri", "com", "org", "edu", "net", "html", "wiki")


def _word(attributes: list[str], children: list[str]) -> Word:
    return Word(
        frozenset(name for name in attributes if not name.endswith("*")),
        frozenset(name for name in children if name[-1] not in "*!"),
        frozenset(name[:-1] for name in attributes if name.endswith("*")),
        frozenset(name[:-1] for name in children if name.endswith("*")),
        frozenset(name[:-1] for name in children if name.endswith("!")),
    )


def _is_known(name: str, words: frozenset[str]) -> bool:
    return name in words or (name.partition(":")[0] + ":") in words


def _kind_and_name(element: Element, within: Element) -> tuple[str, str]:
    """Return how a kind of element is called, and which of them it is."""
    what = f"<{quoted(spelt(element.tag))[1:-1]}>{_NAMES_PLACE} in {_called(within)}"
    return what, element.get("filename") or element.get("name") or ""


def _said(what: str, names: Iterable[str]) -> str:
    """Return a kind of thing with the names of the first few of it."""
    given = [quoted(name) for name in names if name]
    more = [f"{len(given) - _MOST_WORDS} more"] if len(given) > _MOST_WORDS else []
    listed = ", ".join(given[:_MOST_WORDS]) + "".join(f" and {rest}" for rest in more)
    return what.replace(_NAMES_PLACE, f" {listed}" if given else "")


def _called(element: Element) -> str:
    name = element.get("name")
    return f"{spelt(element.tag)} {quoted(name)}" if name else f"<{spelt(element.tag)}>"
