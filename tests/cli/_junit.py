"""Checks a JUnit report against what Jenkins' schema (junit-10) allows: elements, attributes, their order and their totals."""

import re
import xml.etree.ElementTree as ElementTree

# element: (attributes that must be there, attributes that may be there, children)
SCHEMA = {
    "testsuites": ((), ("name", "time", "tests", "failures", "errors"), ("testsuite",)),
    "testsuite": (("name", "tests", "failures", "errors"),
                  ("time", "skipped", "timestamp", "hostname", "id", "package", "group"),
                  ("testsuite", "properties", "testcase", "system-out", "system-err")),
    "testcase": (("name",), ("time", "classname", "group"), ("skipped", "error", "failure", "system-out", "system-err")),
    "failure": ((), ("type", "message"), ()),
    "error": ((), ("type", "message"), ()),
    "skipped": ((), ("type", "message"), ()),
    "system-out": ((), (), ()),
    "system-err": ((), (), ()),
}


def _faults(element):
    if element.tag not in SCHEMA:
        yield f"<{element.tag}> is no element of a report"
        return
    needed, allowed, children = SCHEMA[element.tag]
    yield from (f"<{element.tag}> needs {name}" for name in needed if name not in element.attrib)
    yield from (f"<{element.tag}> has {name}" for name in element.attrib if name not in needed + allowed)
    if not re.fullmatch(r"\d*(\.\d*)?", element.get("time", "0")):
        yield f"<{element.tag}> takes the time {element.get('time')}"
    for child in element:
        if child.tag not in children:
            yield f"<{element.tag}> holds <{child.tag}>"
        yield from _faults(child)
    cases = list(element.iter("testcase"))
    if element.tag in ("testsuites", "testsuite"):
        for name, tag in (("tests", None), ("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
            count = len(cases) if tag is None else sum(one.find(tag) is not None for one in cases)
            if element.get(name, str(count)) != str(count):
                yield f"<{element.tag}> counts {element.get(name)} {name}, not {count}"


def read_junit(path):
    """The root of a report that is valid. Raises AssertionError with what is wrong with it."""
    root = ElementTree.parse(path).getroot()
    faults = list(_faults(root))
    if root.tag != "testsuites":
        faults.append(f"the root is <{root.tag}>")
    assert not faults, faults
    return root
