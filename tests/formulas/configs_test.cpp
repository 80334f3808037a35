#include "reading.hpp"

#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/synthesis/formulas/formula_parser.hpp"
#include "balance/synthesis/formulas/program_code.hpp"

#include <doctest/doctest.h>

#include <filesystem>
#include <set>
#include <string>

using namespace reading;

namespace {

Mechanism arm(const std::vector<Vector3>& axes, const std::vector<Vector3>& places) {
  Mechanism m;
  m.space = SpaceKind::spatial;
  m.gravity = {0, 0, -9.81};
  m.bodies.push_back({.name = "ground"});
  for (std::size_t i = 0; i < axes.size(); ++i) {
    Body body{.name = "link" + std::to_string(i + 1), .mass = 1, .com = {0.1, 0.2, 0.3}};
    body.inertia << 1, 0.1, 0.2, 0.1, 1.5, 0.3, 0.2, 0.3, 1.2;
    m.bodies.push_back(body);
    Joint joint{.name = "J" + std::to_string(i + 1), .first = static_cast<int>(i), .second = static_cast<int>(i) + 1};
    joint.point_first = places[i], joint.axis = axes[i];
    m.joints.push_back(joint);
    m.actuators.push_back(static_cast<int>(i));
  }
  m.coordinates = list_coordinates(m.space, m.joints);
  return m;
}

const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ(), o = Vector3::Zero();

}  // namespace

TEST_CASE(
    "the formulas of every config say what the engine says, at other numbers, too, and with numbers for symbols") {
  // Loops that are redundant close at their own numbers only.
  const std::set<std::string> rigid_elsewhere{"bricard.yaml"};
  int count = 0, elsewhere = 0;
  for (const auto& entry : std::filesystem::directory_iterator(BALANCE_CONFIGS)) {
    if (entry.path().extension() != ".yaml") continue;
    const std::string config = entry.path().filename().string();
    if (has_temporary_payloads(read_spec_file(entry.path().string()).mechanism)) continue;
    for (const bool numbers : {false, true}) try {
        const Sheets s = sheets(config, {}, {}, {.with_values = numbers});
        const FormulaCheck check =
            check_against_engine(s.sheet, s.texts, s.study.mechanism, {.with_perturbed_parameters = !numbers});
        CHECK_MESSAGE(check.is_consistent, config << ": " << check.reason << " " << check.error);
        CHECK(check.states == 5);
        CHECK_MESSAGE((check.note.empty() || rigid_elsewhere.contains(config)), config << ": " << check.note);
        elsewhere += check.perturbed_states;
        ++count;
      } catch (const FormulaError& error) {
        CHECK_MESSAGE(config == "rccc.yaml", config << ": " << std::string(error.what()));  // too long
      }
  }
  CHECK(count > 80);
  CHECK(elsewhere > 60);
}

// generate_program runs what it is about to print against the engine, at the spec's numbers and at others, and throws where they differ.
TEST_CASE("every config has programs, in C and in Python, that say what the engine says, at other numbers, too") {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(BALANCE_CONFIGS)) {
    if (entry.path().extension() != ".yaml") continue;
    const DesignSpace space = read_design_space_file(entry.path().string());
    if (has_temporary_payloads(space.start.mechanism)) continue;
    for (const Language language : {Language::c, Language::python})
      CHECK_NOTHROW_MESSAGE(
          generate_program(space.start.mechanism, specification::read_spec_number_texts(space), language),
          entry.path().filename().string());
    ++count;
  }
  CHECK(count > 45);
}

TEST_CASE("a program is run as it is printed: one with a wrong sign is noticed") {
  const DesignSpace space = read_design_space_file(BALANCE_CONFIGS "/rr.yaml");
  const std::string text =
      generate_program(space.start.mechanism, specification::read_spec_number_texts(space), Language::c);
  ProgramInterpreter right(text, Language::c, 2);
  std::string changed = text;
  const std::size_t sum = changed.find(" + ", changed.find("static void torques("));
  REQUIRE(sum != std::string::npos);
  changed[sum + 1] = '-';
  ProgramInterpreter wrong(changed, Language::c, 2);
  const Sheets s = sheets("rr.yaml");
  for (ProgramInterpreter* program : {&right, &wrong}) {
    for (const Symbol& symbol : s.sheet.ring->symbols()) program->set_parameter(symbol.name, symbol.value);
    program->prepare();
  }
  CHECK(right.compute_torques({0.3, 0.7}, {1, -2}, {2, 1}) != wrong.compute_torques({0.3, 0.7}, {1, -2}, {2, 1}));
}

TEST_CASE("a wrong letter in a formula is noticed") {
  const Sheets s = sheets("rr.yaml");
  auto texts = s.texts;
  std::string& text = texts.at("D12");
  text.replace(text.find("cos"), 3, "sin");
  CHECK_FALSE(check_against_engine(s.sheet, texts, s.study.mechanism).is_consistent);
}

TEST_CASE("a wrong sign in a condition, a closure or what it is solved to is noticed") {
  for (const char* config : {"rr.yaml", "5r.yaml"}) {
    const Sheets s = sheets(config);
    for (std::size_t k = 0; k < s.sections.size(); ++k)
      for (std::size_t f = 0; f < s.sections[k].formulas.size(); ++f) {
        const SheetSectionKind section = s.sections[k].section;
        const bool derived = section == SheetSectionKind::conditions || section == SheetSectionKind::solved;
        if (!derived && s.sections[k].formulas[f].label[0] != 'h') continue;
        auto texts = s.texts;
        std::string& text = texts.at(text_key(k, f, section, s.sections[k].formulas[f].label));
        text.insert(0, "-");
        CHECK_FALSE(check_against_engine(s.sheet, texts, s.study.mechanism).is_consistent);
      }
  }
}

// Counts of an independent trial with another representation; they are a property of the ring, not of the program.
TEST_CASE("the numbers of terms are those of the one form that there is") {
  const auto counts = [](const Mechanism& mechanism) {
    Ring ring;
    const TermCount c = count_terms(derive_equations(
        ring, build_symbolic_tree(ring, mechanism, {}, {.inertial = InertialParametrisation::about_origin})));
    return std::vector<std::size_t>{c.M, c.D, c.z};
  };
  CHECK(counts(arm({z, y, y, y, z, y}, {o, 0.1 * y, 0.4 * z - 0.1 * y, 0.4 * z, 0.1 * y, 0.1 * z})) ==
        std::vector<std::size_t>{800, 2426, 58});
  const auto of_config = [](const char* config) {
    const TermCount c = count_terms(sheets(config).sheet.equations);
    return std::vector<std::size_t>{c.M, c.D, c.z};
  };
  CHECK(of_config("rr.yaml") == std::vector<std::size_t>{24, 9, 11});
  CHECK(of_config("scara-design.yaml") == std::vector<std::size_t>{27, 6, 7});
  CHECK(of_config("3rrr.yaml") == std::vector<std::size_t>{72, 44, 0});  // it lies in a horizontal plane
}

TEST_CASE("mechanisms whose formulas would fill the memory are refused in time, and still have a program") {
  std::vector<Vector3> axes, places;
  for (int k = 0; k < 24; ++k) axes.push_back(k % 2 == 0 ? z : y), places.emplace_back(0.1, 0.2, 0.3);
  const Mechanism snake = arm(axes, places);
  CHECK_THROWS_AS(make_sheet(snake, {}), FormulaError);
  CodeSize size;
  CHECK(generate_program(snake, {}, Language::c, &size).find("torques") != std::string::npos);
  CHECK(size.operations_per_state < 24 * 400);
}
