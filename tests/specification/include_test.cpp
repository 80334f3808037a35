// Specs made of parts: the same mechanism as the one that is written out, and what is told of mistakes in parts.

#include "specs.hpp"

#include "balance/interface/specification/include_expansion.hpp"

#include <doctest/doctest.h>

#include <map>

using namespace balance;

namespace {

using Files = std::map<std::string, std::string>;

const std::string leg = R"(space: planar
parameters: {l: 0.5, r: "l / 2"}
ground: {points: {A: [0.1, 0]}}
bodies:
  crank: {mass: 1, com: [r, 0], inertia: 0.02, points: {A: [0, 0], B: [l, 0]}}
joints:
  A: {type: revolute, connects: [ground.A, crank.A]}
actuators: [A]
counterweights:
  cw: {body: crank, at: [-0.1, 0], mass: {free: [0, 10], start: 1}}
payloads:
  cargo: {body: crank, at: B, mass: 0.5}
springs:
  s: {between: [ground.origin, crank.B], stiffness: 100}
friction: {A: {viscous: 0.1}}
tool: crank.B
design: {goal: static}
)";

std::string flat_text(const std::string& spec, const Files& files) {
  specification::SpecErrorCollector problems("s.yaml");
  const auto text = [&](const std::string& path) {
    const auto found = files.find(path);
    if (found == files.end()) throw SystemError("none at '" + path + "'");
    return found->second;
  };
  try {
    const specification::YamlNode root = specification::parse_yaml(spec, problems);
    return specification::expand_includes(root, "s.yaml", problems, text).text;
  } catch (const specification::ReadError& problem) {
    problems.add(problem);
  }
  problems.throw_if_any();
  return "";
}

/// What is complained about; empty if nothing is.
std::string complaint(const std::string& spec, const Files& files) {
  try {
    flat_text(spec, files);
  } catch (const SpecError& error) {
    return error.what();
  }
  return "";
}

template <class List, class Alike>
void check_lists(const List& a, const List& b, Alike&& alike) {
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(a[i].name == b[i].name);
    CHECK(alike(a[i], b[i]));
  }
}

/// Everything that the sections of a part say, in the same order and to the last bit.
void check_same(const Mechanism& a, const Mechanism& b) {
  check_lists(a.bodies, b.bodies, [](const Body& x, const Body& y) {
    check_lists(x.points, y.points, [](const auto& p, const auto& q) { return p.position == q.position; });
    return x.mass == y.mass && x.com == y.com && x.inertia == y.inertia;
  });
  check_lists(a.joints, b.joints, [](const Joint& x, const Joint& y) {
    return x.type == y.type && x.first == y.first && x.second == y.second && x.point_first == y.point_first &&
           x.point_second == y.point_second && x.axis == y.axis && x.rotation == y.rotation;
  });
  check_lists(a.attachments, b.attachments, [](const Attachment& x, const Attachment& y) {
    return x.kind == y.kind && x.body == y.body && x.position == y.position && x.mass == y.mass;
  });
  check_lists(a.springs, b.springs, [](const Spring& x, const Spring& y) {
    return x.first == y.first && x.second == y.second && x.point_first == y.point_first &&
           x.point_second == y.point_second;
  });
  CHECK(a.actuators == b.actuators);
  CHECK(a.friction.size() == b.friction.size());
}

const std::string head = "space: planar\nbodies: {}\njoints: {}\n";

}  // namespace

TEST_CASE("a part is in the whole what it says, under names of its own") {
  const std::string spec =
      "space: planar\nparameters: {l: 3, k: 2}\n"
      "include: {file: leg.yaml, as: [a, b], set: {l: {b: \"k / 4\"}}, without: [payloads]}\n";
  const std::string written = R"(space: planar
parameters: {l: 3, k: 2, a.l: 0.5, a.r: "a.l / 2", b.l: "k / 4", b.r: "b.l / 2"}
ground: {points: {a.A: [0.1, 0], a.origin: [0, 0], b.A: [0.1, 0], b.origin: [0, 0]}}
bodies:
  a.crank: {mass: 1, com: [a.r, 0], inertia: 0.02, points: {A: [0, 0], B: [a.l, 0]}}
  b.crank: {mass: 1, com: [b.r, 0], inertia: 0.02, points: {A: [0, 0], B: [b.l, 0]}}
joints:
  a.A: {type: revolute, connects: [ground.a.A, a.crank.A]}
  b.A: {type: revolute, connects: [ground.b.A, b.crank.A]}
actuators: [a.A, b.A]
counterweights:
  a.cw: {body: a.crank, at: [-0.1, 0], mass: {free: [0, 10], start: 1}}
  b.cw: {body: b.crank, at: [-0.1, 0], mass: {free: [0, 10], start: 1}}
springs:
  a.s: {between: [ground.a.origin, a.crank.B], stiffness: 100}
  b.s: {between: [ground.b.origin, b.crank.B], stiffness: 100}
friction: {a.A: {viscous: 0.1}, b.A: {viscous: 0.1}}
)";
  const Study study = specs::read(flat_text(spec, {{"leg.yaml", leg}}));
  check_same(study.mechanism, specs::read(written).mechanism);
  REQUIRE(study.free_numbers.size() == 2);
  CHECK(study.free_numbers[1].key_path == "counterweights.b.cw.mass");
  CHECK_FALSE(study.mechanism.tool);
  CHECK(study.design.goals.empty());
}

TEST_CASE("a part that is placed hangs at a body without mass, wherever its carrier is") {
  const std::string spec =
      "space: planar\ninclude:\n"
      "  - {file: leg.yaml, as: a, at: [1, 2], angle: \"pi / 2\", without: [springs, payloads, counterweights]}\n"
      "  - {file: leg.yaml, as: b, on: a.crank, without: [springs, payloads, counterweights]}\n";
  const std::string written = R"(space: planar
parameters: {a.l: 0.5, a.r: "a.l / 2", b.l: 0.5, b.r: "b.l / 2"}
ground: {points: {a: [1, 2]}}
bodies:
  a.crank: {mass: 1, com: [a.r, 0], inertia: 0.02, points: {A: [0, 0], B: [a.l, 0], b.A: [0.1, 0]}}
  a.ground: {mass: 0, points: {A: [0.1, 0]}}
  b.crank: {mass: 1, com: [b.r, 0], inertia: 0.02, points: {A: [0, 0], B: [b.l, 0]}}
joints:
  a.A: {type: revolute, connects: [a.ground.A, a.crank.A]}
  a.ground: {type: fixed, connects: [ground.a, a.ground.origin], angle: "pi / 2"}
  b.A: {type: revolute, connects: [a.crank.b.A, b.crank.A]}
actuators: [a.A, b.A]
friction: {a.A: {viscous: 0.1}, b.A: {viscous: 0.1}}
)";
  check_same(specs::read(flat_text(spec, {{"leg.yaml", leg}})).mechanism, specs::read(written).mechanism);
}

TEST_CASE("parts of parts have their names one behind the other") {
  const Files files{{"legs/leg.yaml", leg},
                    {"legs/pair.yaml", "space: planar\ninclude: {file: leg.yaml, as: [l, r], at: {r: [0, 1]}}\n"}};
  const std::string text = flat_text("space: planar\ninclude: {file: legs/pair.yaml, as: p}\n", files);
  const Study study = specs::read(text);
  std::string names;
  for (const Body& body : study.mechanism.bodies) names += body.name + " ";
  CHECK(names == "ground p.l.crank p.r.crank p.r.ground ");
  CHECK(study.mechanism.bodies[0].points[0].name == "p.l.A");
  CHECK(specs::read(text, {.set = {{"p.l.l", "2"}}}).mechanism.bodies[1].com[0] == 1);
}

TEST_CASE("a free parameter that is shared is one number, another is one for each copy") {
  const std::string free = specs::with(leg, "l: 0.5", "l: {free: [0.1, 1]}");
  const auto count = [&](const std::string& set) {
    const Study study = specs::read(
        flat_text("space: planar\ninclude: {file: leg.yaml, as: [a, b], without: counterweights" + set + "}\n",
                  {{"leg.yaml", free}}));
    CHECK(study.mechanism.bodies[1].com == study.mechanism.bodies[2].com);
    return study.free_numbers.size();
  };
  CHECK(count("") == 2);
  CHECK(count(", set: {l: shared}") == 1);
  CHECK(count(", set: {l: {free: [1, 2]}}") == 2);
  CHECK(count(", set: {l: {a: {free: [1, 2]}, b: 1.5}}") == 1);
}

TEST_CASE("what is wrong with parts is reported with the file, the place and what was expected") {
  const Files files{{"leg.yaml", leg},
                    {"self.yaml", "space: planar\ninclude: {file: self.yaml, as: x}\n"},
                    {"ring.yaml", "space: planar\ninclude: {file: s.yaml, as: x}\n"},
                    {"flat.yaml", "space: spatial\n"},
                    {"mm.yaml", "space: planar\nunits: {length: mm}\n"},
                    {"odd.yaml", "space: planar\nbodeis: {}\n"},
                    {"secret", "root:x:0\n"},
                    {"none.yaml", "space: planar\nbodies:\n"},
                    {"open.yaml", "space: [planar\n"}};
  const auto message_for = [&](const std::string& include) {
    return complaint(head + "include: " + include + "\n", files);
  };
  CHECK(message_for("leg.yaml") ==
        "s.yaml:4:10: include: expected a part {file, as} or a list of them, found 'leg.yaml'");
  CHECK(message_for("{file: leg.yaml}") == "s.yaml:4:10: include: missing key: expected 'as', found only file");
  CHECK(message_for("{file: leg.yml, as: a}") ==
        "s.yaml:4:17: include.file: expected the file of a part, found none at 'leg.yml'");
  CHECK(message_for("{file: leg.yaml, as: a b}") ==
        "s.yaml:4:31: include.as: expected a name of letters, digits, '_' and '-', found 'a b'");
  CHECK(message_for("{file: leg.yaml, as: [a, a]}") ==
        "s.yaml:4:35: include.as[1]: expected an unused name, found 'a', another copy's");
  CHECK(message_for("{file: leg.yaml, as: ground}") ==
        "s.yaml:4:31: include.as: expected an unused name, found 'ground', a body's");
  CHECK(message_for("{file: leg.yaml, as: a, on: b}") ==
        "s.yaml:4:38: include.on: expected a body defined above the part (ground), found 'b'");
  CHECK(message_for("{file: leg.yaml, as: a, set: {q: 1}}") ==
        "s.yaml:4:40: include.set.q: expected a parameter of the part (l or r), found 'q'");
  CHECK(message_for("{file: leg.yaml, as: [a, b], at: {c: [0, 0]}}") ==
        "s.yaml:4:44: include.at.c: expected one of the copies (a or b), found 'c'");
  CHECK(message_for("{file: leg.yaml, as: a, without: springs.t}") ==
        "s.yaml:4:43: include.without: expected the name of something in the part (springs.s), found 'springs.t'; "
        "nearest is "
        "'springs.s'");
  CHECK(message_for("{file: self.yaml, as: a}") ==
        "self.yaml:2:17: include.file: expected a file that does not include itself, found s.yaml → self.yaml → "
        "self.yaml");
  CHECK(
      message_for("{file: ring.yaml, as: a}") ==
      "ring.yaml:2:17: include.file: expected a file that does not include itself, found s.yaml → ring.yaml → s.yaml");
  CHECK(
      message_for("{file: flat.yaml, as: a}") ==
      "s.yaml:4:17: include.file: expected a part whose space is 'planar', as in the including spec, found 'spatial'");
  CHECK(message_for("{file: mm.yaml, as: a}") ==
        "s.yaml:4:17: include.file: expected a part in the units of the including spec, found different units in "
        "'mm.yaml'");
  CHECK(message_for("{file: odd.yaml, as: a}").starts_with("odd.yaml:2:1: bodeis: unknown key: expected"));
  CHECK(message_for("{file: none.yaml, as: a}") == "none.yaml:2:1: bodies: expected a mapping, found nothing");
  CHECK(message_for("{file: secret, as: a}") ==
        "secret:1:1: expected a part: a mapping with 'space', 'bodies', 'joints', …, found something else");
  CHECK(message_for("{file: open.yaml, as: a}").starts_with("open.yaml:1:8: expected YAML"));
}

TEST_CASE("a mistake in a part is reported once, at the part's own place") {
  try {
    read_spec("space: planar\ninclude: {file: parts/bad_leg.yaml, as: [a, b]}\n", BALANCE_TEST_DATA "/s.yaml");
    FAIL("a negative mass");
  } catch (const SpecError& error) {
    CHECK(std::string(error.what()) == BALANCE_TEST_DATA
          "/parts/bad_leg.yaml:4:17: bodies.a.crank.mass: must be positive: expected a number > 0, found -1");
  }
}

TEST_CASE("parts that grow without end are refused before they grow") {
  Files files{{"p0.yaml", leg}};
  for (int i = 1; i <= 20; ++i)
    files["p" + std::to_string(i) + ".yaml"] =
        "space: planar\ninclude: {file: p" + std::to_string(i - 1) + ".yaml, as: [a, b, c, d, e, f, g, h, i, j]}\n";
  CHECK(complaint(head + "include: {file: p6.yaml, as: x}\n", files).find("at most 200000 values in a spec") !=
        std::string::npos);
  CHECK(complaint(head + "include: {file: p20.yaml, as: x}\n", files).find("parts nested at most 8 deep") !=
        std::string::npos);
}

TEST_CASE("names with points are a body's or a point's, a joint's or a coordinate's, never both") {
  const std::string body =
      specs::with(specs::planar, "  wheel: {", "  upper.arm: {mass: 1, com: [0, 0], inertia: 1}\n  wheel: {");
  CHECK(
      specs::complaint(body).find("a name that does not start with another body's name and '.', found 'upper.arm' and "
                                  "'upper'") != std::string::npos);
  const std::string joint =
      specs::with(specs::planar, "  D: {type", "  D.slide: {type: fixed, connects: [lower.H, upper.A]}\n  D: {type");
  CHECK(specs::complaint(joint).find("found 'D.slide' and 'D'") != std::string::npos);
}
