#include "balance/interface/reports/identified_spec.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/interface/specification/display_units.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/interface/specification/spec_edit.hpp"
#include "balance/mechanics/dynamics/dynamic_parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace balance::reports {

using identification::UnknownKind;
using specification::format_yaml_number;
using specification::SpecEdit;

namespace {

/// Relative difference between the identified mechanism and its spec: numbers have twelve digits.
constexpr double read_back_tolerance = 1e-9;

/// SI values of the units that numbers of a spec are in.
struct UnitFactors {
  double length = 1, mass = 1, angle = 1, time = 1, force = 1;  ///< SI

  double inertia() const { return mass * length * length; }
};

class IdentifiedSpecWriter {
 public:
  IdentifiedSpecWriter(const Study& study, const identification::Identification& found) : study_(study), found_(found) {
    const specification::SpecUnits units = specification::read_display_units(study.spec_text);
    units_ = {units.length, units.mass, units.angle, units.time, specification::read_force_unit(study.spec_text)};
  }

  IdentifiedSpec write() {
    expected_ = found_.mechanism;
    for (Friction& friction : expected_.friction) clip(friction);
    for (Disc& disc : expected_.discs) make_possible(disc);
    for (std::size_t k = 0; k < found_.unknowns.size(); ++k) write_element(k);
    write_friction();
    write_gains();
    write_tolerances();
    IdentifiedSpec spec;
    try {
      spec.text = specification::edit_spec(study_.spec_text, edits_);
    } catch (const specification::SpecEditError& error) {
      fail(error.what());
    }
    check(spec.text);
    spec.notes = notes_;
    return spec;
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw SpecError({.place = {.file = study_.spec_file},
                     .message = "the identified numbers cannot be written into this spec: " + reason});
  }

  void clip(Friction& friction) {
    const std::string& name = study_.mechanism.coordinates[static_cast<std::size_t>(friction.coordinate)].name;
    for (const auto& [value, what] : {std::pair{&friction.viscous, "viscous"}, std::pair{&friction.coulomb, "Coulomb"}})
      if (*value < 0) {
        notes_.push_back(
            fmt::format("{} friction of {} was negative, {:.3g}, and is written as 0", what, name, *value));
        *value = 0;
      }
  }

  /// A disc has at least half of its axial inertia across its axis. What it lacks is moved there from its carrier, which
  /// moves as before.
  void make_possible(Disc& disc) {
    if (study_.mechanism.space == SpaceKind::planar) return;
    const double axial = disc.axis.dot(disc.inertia * disc.axis), transverse = (disc.inertia.trace() - axial) / 2;
    const double lacking = axial / 2 - transverse;
    if (!(lacking > 0)) return;
    const Matrix3 across = lacking * (Matrix3::Identity() - disc.axis * disc.axis.transpose());
    disc.inertia += across;
    if (disc.body != model::ground) expected_.bodies[static_cast<std::size_t>(disc.body)].inertia -= across;
  }

  std::string vector_text(const Vector3& v, double unit) const {
    const int axes = study_.mechanism.space == SpaceKind::planar ? 2 : 3;
    std::string text;
    for (int k = 0; k < axes; ++k) text += (k == 0 ? "" : ", ") + format_yaml_number(v[k] / unit);
    return "[" + text + "]";
  }

  std::string inertia_text(const Matrix3& I) const {
    if (study_.mechanism.space == SpaceKind::planar) return format_yaml_number(I(2, 2) / units_.inertia());
    std::string text;
    for (const double entry : {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)})
      text += (text.empty() ? "" : ", ") + format_yaml_number(entry / units_.inertia());
    return "[" + text + "]";
  }

  void set(std::vector<std::string> path, std::string value) { edits_.push_back({std::move(path), std::move(value)}); }

  void write_element(std::size_t k) {
    const identification::UnknownParameter& unknown = found_.unknowns[k].unknown;
    const auto index = static_cast<std::size_t>(unknown.element);
    if (unknown.kind == UnknownKind::body && unknown.slot == 0) {
      const Body& body = expected_.bodies[index];
      set({"bodies", body.name, "mass"}, format_yaml_number(body.mass / units_.mass));
      set({"bodies", body.name, "com"}, vector_text(body.com, units_.length));
      set({"bodies", body.name, "inertia"}, inertia_text(body.inertia));
    }
    if (unknown.kind == UnknownKind::payload && unknown.slot == 0) {
      const Attachment& payload = expected_.attachments[index];
      set({"payloads", payload.name, "mass"}, format_yaml_number(payload.mass / units_.mass));
      set({"payloads", payload.name, "at"}, vector_text(payload.position, units_.length));
      set({"payloads", payload.name, "inertia"}, inertia_text(payload.inertia));
    }
    if (unknown.kind != UnknownKind::disc_inertia) return;
    const Disc& disc = expected_.discs[index];
    set({"discs", disc.name, "inertia"}, inertia_text(disc.inertia));
  }

  void write_friction() {
    std::map<int, double> offsets;
    for (const Spring& spring : expected_.springs)
      if (spring.is_joint_spring() && spring.stiffness == 0) offsets[spring.coordinate] = -spring.preload;
    for (const Friction& friction : expected_.friction) {
      const bool is_angle = !is_length_coordinate(study_.mechanism, friction.coordinate);
      const double effort = is_angle ? units_.force * units_.length : units_.force;
      const double viscous = effort * units_.time / (is_angle ? units_.angle : units_.length);
      std::string text = "viscous: " + format_yaml_number(friction.viscous / viscous);
      if (friction.coulomb != 0) text += ", coulomb: " + format_yaml_number(friction.coulomb / effort);
      if (offsets.count(friction.coordinate) > 0)
        text += ", offset: " + format_yaml_number(offsets[friction.coordinate] / effort);
      set({"friction", study_.mechanism.coordinates[static_cast<std::size_t>(friction.coordinate)].name},
          "{" + text + "}");
    }
  }

  /// Those of the spec too, which may state one for all.
  void write_gains() {
    std::map<CoordinateId, double> gains(study_.current_gains.begin(), study_.current_gains.end());
    bool has_currents = false;
    for (const identification::ChannelReport& channel : found_.channels) {
      if (!channel.gain) continue;
      gains[study_.mechanism.actuators[static_cast<std::size_t>(channel.signal.index)]] = *channel.gain;
      has_currents = true;
    }
    if (!has_currents) return;
    std::string text;
    for (const auto& [coordinate, gain] : gains) {
      const double effort =
          is_length_coordinate(study_.mechanism, coordinate) ? units_.force : units_.force * units_.length;
      text += fmt::format("{}{}: {}", text.empty() ? "" : ", ",
                          study_.mechanism.coordinates[static_cast<std::size_t>(coordinate)].name,
                          format_yaml_number(gain / effort));
    }
    set({"current_gains"}, "{" + text + "}");
  }

  /// Deviations of base parameters, as those of the numbers that they are named after: the others are then exact by
  /// definition, since only the combination was measured.
  void write_tolerances() {
    for (const identification::BaseParameter& parameter : found_.base) {
      if (!parameter.is_found || !(parameter.deviation > 0)) continue;
      const auto match = std::find_if(found_.unknowns.begin(), found_.unknowns.end(),
                                      [&](const auto& one) { return one.unknown.name == parameter.name; });
      const identification::UnknownParameter& unknown = match->unknown;
      if (unknown.kind != UnknownKind::body) continue;
      const Body& body = expected_.bodies[static_cast<std::size_t>(unknown.element)];
      const bool is_planar = study_.mechanism.space == SpaceKind::planar;
      const int axes = is_planar ? 2 : 3;
      std::string key;
      double unit = 1;
      if (unknown.slot == 0)
        key = "mass", unit = units_.mass;
      else if (unknown.slot <= axes)
        key = fmt::format("com[{}]", unknown.slot - 1), unit = units_.length * body.mass;
      else
        key = is_planar ? "inertia" : fmt::format("inertia[{}]", unknown.slot - 4), unit = units_.inertia();
      set({"tolerances", "bodies." + body.name + "." + key}, format_yaml_number(parameter.deviation / unit, 3));
    }
  }

  void check(const std::string& text) const {
    try {
      const Mechanism read = specification::read_spec(text, study_.spec_file).mechanism;
      const auto inertias_of = [](Mechanism mechanism) {
        mechanism.springs.clear();
        return dynamics::parameter_values(mechanism);
      };
      const VectorX values = inertias_of(read), wanted = inertias_of(expected_);
      const bool has_inertias = values.size() == wanted.size() && numerics::max_abs(VectorX(values - wanted)) <=
                                                                      read_back_tolerance * numerics::max_abs(wanted);
      bool has_friction = read.friction.size() == expected_.friction.size();
      for (const Friction& friction : expected_.friction)
        has_friction =
            has_friction && std::any_of(read.friction.begin(), read.friction.end(), [&](const Friction& one) {
              const auto is_equal = [](double a, double b) {
                return std::abs(a - b) <= read_back_tolerance * std::abs(b);
              };
              return one.coordinate == friction.coordinate && is_equal(one.viscous, friction.viscous) &&
                     is_equal(one.coulomb, friction.coulomb);
            });
      if (!has_inertias || !has_friction) fail("it would not give the identified mechanism");
    } catch (const SpecError& error) {
      fail(error.summary());
    }
  }

  const Study& study_;
  const identification::Identification& found_;
  UnitFactors units_;
  Mechanism expected_;
  std::vector<SpecEdit> edits_;
  std::vector<std::string> notes_;
};

}  // namespace

IdentifiedSpec format_identified_spec(const Study& study, const identification::Identification& found) {
  return IdentifiedSpecWriter(study, found).write();
}

}  // namespace balance::reports
