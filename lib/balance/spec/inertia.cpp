#include "balance/spec/inertia.hpp"

#include "balance/spec/directions.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::specification {

namespace {

/// Steiner's theorem from the origin to the centre of mass.
Matrix3E shift_to_com(const Matrix3E& about_origin, const Expression& mass, const Vector3E& com, bool planar) {
  const auto moment = [&](int i, int j) { return mass * com[i] * com[j]; };
  Matrix3E inertia = about_origin;
  for (int i = planar ? 2 : 0; i < 3; ++i)
    inertia(i, i) -= moment((i + 1) % 3, (i + 1) % 3) + moment((i + 2) % 3, (i + 2) % 3);
  for (int i = 0; i < 3 && !planar; ++i)
    for (int j = 0; j < 3; ++j)
      if (i != j) inertia(i, j) += moment(j, i);
  return inertia;
}

}  // namespace

Matrix3E read_inertia_value(const SpecCursor& at, StudyBuilder& draft) {
  Matrix3E inertia = Matrix3E::Zero();
  if (draft.planar()) {
    inertia(2, 2) = read_number(at, draft, dimension::inertia);
    return inertia;
  }
  const std::string what = "[Ixx, Iyy, Izz] or [Ixx, Iyy, Izz, Ixy, Ixz, Iyz]";
  if (at.is_list() && at.node().items.size() != 3 && at.node().items.size() != 6) at.fail_expected(what);
  const auto v = read_numbers(at, draft, dimension::inertia, what);
  for (int i = 0; i < 3; ++i) inertia(i, i) = v[static_cast<std::size_t>(i)];
  if (v.size() == 6) {
    inertia(0, 1) = inertia(1, 0) = v[3];
    inertia(0, 2) = inertia(2, 0) = v[4];
    inertia(1, 2) = inertia(2, 1) = v[5];
  }
  return inertia;
}

namespace {

/// What `{about: …, value: …}` says; `as_given` in place of `value`.
struct InertiaKeys {
  bool about_origin = false;
  bool as_given = false;
  Matrix3E value = Matrix3E::Zero();
};

InertiaKeys read_inertia_text(const SpecCursor& at, StudyBuilder& draft) {
  // A mapping with `free` is a free number, not a choice of the reference point.
  const bool is_free =
      at.is_map() && !at.node().keys.empty() && (at.node().keys[0].text == "free" || at.node().keys[0].text == "start");
  InertiaKeys text;
  if (!at.is_map() || is_free) {
    text.value = read_inertia_value(at, draft);
    return text;
  }
  const auto& keys = at.node().keys;
  text.as_given = std::any_of(keys.begin(), keys.end(), [](const YamlNode& key) { return key.text == "as_given"; });
  const char* name = text.as_given ? "as_given" : "value";
  const bool read = read_fields(
      at, "an inertia",
      {{"about", text.as_given ? Presence::optional : Presence::required,
        [&](const SpecCursor& c) {
          text.about_origin = c.read_choice("the point that the inertia is about", {"com", "origin"}) == 1;
        }},
       {name, Presence::required, [&](const SpecCursor& c) { text.value = read_inertia_value(c, draft); }}});
  if (!read) throw CascadingError();
  return text;
}

/// A warning in place of the mistake that it would be without `as_given`.
void warn_of_inertia(const SpecCursor& at, const Matrix3E& inertia, StudyBuilder& draft) {
  try {
    check_inertia(at, inertia, draft, InertiaOwner::body);
  } catch (const ReadError& problem) {
    const SourceLocation place{draft.problems.file_of(problem.place), problem.place.line, problem.place.column,
                               problem.path};
    draft.study.warnings.push_back(place.text() + ": kept as given: " + problem.message.text());
  }
}

}  // namespace

Matrix3E read_inertia(const SpecCursor& at, StudyBuilder& draft, const std::optional<Expression>& mass,
                      const Vector3E& com) {
  const InertiaKeys text = read_inertia_text(at, draft);
  if (text.about_origin && !mass) return text.value;
  const Matrix3E inertia = text.about_origin ? shift_to_com(text.value, *mass, com, draft.planar()) : text.value;
  if (text.as_given)
    warn_of_inertia(at, inertia, draft);
  else
    check_inertia(at, inertia, draft, InertiaOwner::body);
  return inertia;
}

void check_inertia(const SpecCursor& at, const Matrix3E& inertia, const StudyBuilder& draft, InertiaOwner bearer) {
  const bool planar = draft.planar();
  const InertiaCheck verdict = find_inertia_issue(values_of(inertia), planar, bearer);
  if (verdict.issue == InertiaIssue::none) return;
  const Vector3& principal = verdict.principal_moments;
  const char* expected = verdict.issue == InertiaIssue::triangle_violated
                             ? "no principal moment above the sum of the other two"
                         : !planar                      ? "a positive definite matrix"
                         : bearer == InertiaOwner::body ? "a positive one about its CoM"
                                                        : "one that is not negative about its CoM";
  at.fail({.kind = "no body can have this inertia",
           .expected = expected,
           .found = planar ? fmt::format("{:.6g} kg m^2", principal[2])
                           : fmt::format("the principal moments {:.6g}, {:.6g}, {:.6g} kg m^2 about its CoM",
                                         principal[0], principal[1], principal[2])});
}

}  // namespace balance::specification
