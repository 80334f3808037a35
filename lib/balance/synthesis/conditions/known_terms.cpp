#include "balance/synthesis/conditions/known_terms.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/conditions/goal_rows.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace balance::conditions {

using dynamics::Parameter;
using dynamics::ParameterOwner;

namespace {

/// Relative to the largest change: smaller ones count as none.
constexpr double load_change_tolerance = 1e-12;

int component_count(const Mechanism& mechanism) { return mechanism.space == SpaceKind::planar ? 3 : 6; }

/// Force, then moment: planar fx, fy, m; spatial fx, fy, fz, mx, my, mz.
VectorX join_components(const Vector3& force, const Vector3& moment, int size) {
  if (size == 3) return Vector3(force.x(), force.y(), moment.z());
  VectorX wrench(6);
  wrench << force, moment;
  return wrench;
}

VectorX load_at_entry(const Load& load, std::size_t entry, int size) {
  return join_components(load.force[entry], load.moment[entry], size);
}

VectorX load_at(const model::LoadTable<double>& table, double argument, int size) {
  Vector3 force, moment;
  table.evaluate(argument, force, moment);
  return join_components(force, moment, size);
}

VectorX peak_components(const Load& load, int size) {
  VectorX peak = VectorX::Zero(size);
  for (std::size_t k = 0; k < load.force.size(); ++k) peak = peak.cwiseMax(load_at_entry(load, k, size).cwiseAbs());
  return peak;
}

std::string section_of(const ForceElement& element) { return element.is_damper() ? "dampers" : "springs"; }

double known_value(const ForceElement& element) {
  return element.is_damper() ? element.damping : model::ForceLawOf<double>(element.table).max_force();
}

std::string owner_of(const Mechanism& mechanism, ParameterOwner owner_kind, std::size_t index) {
  if (owner_kind == ParameterOwner::force_element) return mechanism.force_elements[index].name;
  return owner_kind == ParameterOwner::load
             ? mechanism.loads[index].name
             : mechanism.coordinates[static_cast<std::size_t>(mechanism.friction[index].coordinate)].name;
}

constexpr const char* time_suffix = "(t)";

/// Of the symbols of a load's terms: its initial value and its change over time, or its values over a coordinate.
std::vector<std::string> load_suffixes(const Mechanism& mechanism, const Load& load) {
  if (!load.is_over_coordinate())
    return load.arguments.empty() ? std::vector<std::string>{""} : std::vector<std::string>{"", time_suffix};
  const std::string suffix = "(" + mechanism.coordinates[static_cast<std::size_t>(load.coordinate)].name + ")";
  return {suffix == time_suffix ? "(joint t)" : suffix};
}

/// Names of all other owners of columns of conditions.
std::set<std::string> other_owners(const Mechanism& mechanism) {
  std::set<std::string> names;
  for (const Body& body : mechanism.bodies) names.insert(body.name);
  for (const Attachment& attachment : mechanism.attachments) names.insert(attachment.name);
  for (const Disc& disc : mechanism.discs) names.insert(disc.name);
  for (const Spring& spring : mechanism.springs) names.insert(spring.name);
  return names;
}

}  // namespace

MatrixX load_histories(const Mechanism& mechanism) {
  const int size = component_count(mechanism);
  std::set<double> times;
  for (const Load& load : mechanism.loads)
    if (load.is_over_time()) times.insert(load.arguments.begin(), load.arguments.end());
  MatrixX changes =
      MatrixX::Zero(static_cast<Eigen::Index>(times.size()), size * static_cast<Eigen::Index>(mechanism.loads.size()));
  Eigen::Index row = 0;
  for (const double time : times) {
    Eigen::Index column = 0;
    for (const Load& load : mechanism.loads) {
      if (load.is_over_time())
        changes.row(row).segment(column, size) =
            load_at(model::LoadTable<double>(load), time, size) - load_at_entry(load, 0, size);
      column += size;
    }
    ++row;
  }
  return changes;
}

double relative_load(const model::LoadTable<double>& table, const Parameter& term, double coordinate, bool planar) {
  const int size = planar ? 3 : 6, component = term.slot % size;
  const double peak = peak_components(table.load(), size)[component];
  return peak > 0 ? load_at(table, coordinate, size)[component] / peak : 0;
}

Eigen::Index load_component(const Parameter& term, bool planar) {
  const int size = planar ? 3 : 6;
  return size * term.index + term.slot % size;
}

double& friction_coefficient(Friction& friction, const Parameter& term) {
  if (term.kind == dynamics::ParameterKind::viscous) return friction.viscous;
  return term.symbol == coulomb_backward && friction.coulomb_backward ? *friction.coulomb_backward : friction.coulomb;
}

double friction_resistance(const Parameter& term, double rate) {
  if (term.kind == dynamics::ParameterKind::viscous) return rate;
  if (rate > 0) return term.symbol == coulomb_backward ? 0 : 1;
  return rate < 0 && term.symbol != coulomb_forward ? -1 : 0;
}

bool is_known_term(const Parameter& parameter) {
  return parameter.owner_kind == ParameterOwner::load || parameter.owner_kind == ParameterOwner::friction ||
         parameter.owner_kind == ParameterOwner::force_element;
}

bool is_load_change(const Parameter& parameter) {
  return parameter.owner_kind == ParameterOwner::load && parameter.symbol.ends_with(time_suffix);
}

std::vector<Parameter> list_known_terms(const Mechanism& mechanism) {
  const int size = component_count(mechanism);
  const std::vector<std::string> symbols = size == 3 ? std::vector<std::string>{"fx", "fy", "m"}
                                                     : std::vector<std::string>{"fx", "fy", "fz", "mx", "my", "mz"};
  const std::set<std::string> other_names = other_owners(mechanism);
  std::vector<Parameter> terms;
  const auto add_term = [&](ParameterOwner owner_kind, std::size_t index, const std::string& symbol,
                            dynamics::ParameterKind kind, int power) {
    std::string owner = owner_of(mechanism, owner_kind, index);
    if (other_names.count(owner) > 0)
      owner = (owner_kind == ParameterOwner::load       ? "loads"
               : owner_kind == ParameterOwner::friction ? "friction"
                                                        : section_of(mechanism.force_elements[index])) +
              "." + owner;
    const int slot =
        terms.empty() || terms.back().owner_kind != owner_kind || terms.back().index != static_cast<int>(index)
            ? 0
            : terms.back().slot + 1;
    terms.push_back({owner + "." + symbol, owner, symbol, owner_kind, static_cast<int>(index), slot, kind, power});
  };
  for (std::size_t l = 0; l < mechanism.loads.size(); ++l)
    for (const std::string& suffix : load_suffixes(mechanism, mechanism.loads[l])) {
      for (int c = 0; c < size; ++c) {
        const bool is_couple = c >= (size == 3 ? 2 : 3);
        add_term(ParameterOwner::load, l, symbols[static_cast<std::size_t>(c)] + suffix,
                 is_couple ? dynamics::ParameterKind::couple : dynamics::ParameterKind::force, is_couple ? 1 : 0);
      }
    }
  for (std::size_t f = 0; f < mechanism.friction.size(); ++f) {
    const CoordinateId coordinate = mechanism.friction[f].coordinate;
    const bool is_angle = mechanism.coordinates[static_cast<std::size_t>(coordinate)].kind == CoordinateKind::angle;
    add_term(ParameterOwner::friction, f, "viscous", dynamics::ParameterKind::viscous, is_angle ? 2 : 0);
    for (const char* symbol : mechanism.friction[f].coulomb_backward
                                  ? std::vector<const char*>{coulomb_forward, coulomb_backward}
                                  : std::vector<const char*>{"coulomb"})
      add_term(ParameterOwner::friction, f, symbol, dynamics::ParameterKind::coulomb, is_angle ? 2 : 1);
  }
  for (std::size_t e = 0; e < mechanism.force_elements.size(); ++e) {
    const ForceElement& element = mechanism.force_elements[e];
    const bool is_couple = element.is_in_joint() && !is_length_coordinate(mechanism, element.coordinate);
    if (element.is_damper())
      add_term(ParameterOwner::force_element, e, "damping", dynamics::ParameterKind::viscous, 0);
    else
      add_term(ParameterOwner::force_element, e, "table", dynamics::ParameterKind::tabulated, is_couple ? 1 : 0);
  }
  return terms;
}

VectorX known_term_values(const Mechanism& mechanism) {
  const int size = component_count(mechanism);
  const MatrixX changes = load_histories(mechanism);
  std::vector<double> values;
  for (std::size_t l = 0; l < mechanism.loads.size(); ++l) {
    const Load& load = mechanism.loads[l];
    if (load.is_over_coordinate()) {
      const VectorX peak = peak_components(load, size);
      values.insert(values.end(), peak.begin(), peak.end());
      continue;
    }
    const VectorX first = load_at_entry(load, 0, size);
    values.insert(values.end(), first.begin(), first.end());
    if (load.arguments.empty()) continue;
    for (int c = 0; c < size; ++c) {
      const VectorX change = changes.col(size * static_cast<Eigen::Index>(l) + c);
      values.push_back(change[numerics::max_index(change.cwiseAbs())]);
    }
  }
  for (const Friction& friction : mechanism.friction) {
    values.insert(values.end(), {friction.viscous, friction.coulomb});
    if (friction.coulomb_backward) values.push_back(*friction.coulomb_backward);
  }
  for (const ForceElement& element : mechanism.force_elements) values.push_back(known_value(element));
  return Eigen::Map<const VectorX>(values.data(), static_cast<Eigen::Index>(values.size()));
}

std::vector<Parameter> list_terms(const Mechanism& mechanism, const dynamics::FreeSprings& loose) {
  std::vector<Parameter> terms = dynamics::list_parameters(mechanism, loose);
  for (Parameter& term : list_known_terms(mechanism)) terms.push_back(std::move(term));
  return terms;
}

VectorX term_values(const Mechanism& mechanism, const dynamics::FreeSprings& loose) {
  const VectorX parameters = dynamics::parameter_values(mechanism, loose), known = known_term_values(mechanism);
  VectorX values(parameters.size() + known.size());
  values << parameters, known;
  return values;
}

MatrixX load_changes(const Mechanism& mechanism, double length) {
  const int size = component_count(mechanism), forces = size == 3 ? 2 : 3;
  MatrixX changes = load_histories(mechanism);
  const Eigen::Index n = changes.cols();
  MatrixX coupling = MatrixX::Zero(n, n);
  if (changes.rows() == 0) return coupling;
  VectorX unit(n);
  for (Eigen::Index c = 0; c < n; ++c) unit[c] = c % size < forces ? 1 : length;
  changes = changes * unit.cwiseInverse().asDiagonal();
  numerics::ColumnPivotingQr qr;
  qr.setThreshold(load_change_tolerance);
  qr.compute(changes);
  const Eigen::Index rank = changes.isZero(0) ? 0 : qr.rank();
  const auto& order = qr.colsPermutation().indices();
  // the other components' changes are linear combinations of those of the first `rank` ones in this order
  const MatrixX combination = qr.matrixQR()
                                  .topLeftCorner(rank, rank)
                                  .template triangularView<Eigen::Upper>()
                                  .solve(qr.matrixQR().topRightCorner(rank, n - rank));
  for (Eigen::Index i = 0; i < rank; ++i) {
    const Eigen::Index independent = order[i];
    coupling(independent, independent) = 1;
    for (Eigen::Index j = rank; j < n; ++j)
      if (std::abs(combination(i, j - rank)) > load_change_tolerance)
        coupling(order[j], independent) = combination(i, j - rank) * unit[order[j]] / unit[independent];
  }
  return coupling;
}

bool is_excluded(const Mechanism& mechanism, const Parameter& term, const std::vector<std::string>& names) {
  std::string section, name;
  const auto index = static_cast<std::size_t>(term.index);
  switch (term.owner_kind) {
    case ParameterOwner::body: return false;
    case ParameterOwner::attachment:
      section = mechanism.attachments[index].kind == AttachmentKind::payload ? "payloads" : "counterweights";
      name = mechanism.attachments[index].name;
      break;
    case ParameterOwner::disc: section = "discs", name = mechanism.discs[index].name; break;
    case ParameterOwner::spring: section = "springs", name = mechanism.springs[index].name; break;
    case ParameterOwner::load: section = "loads", name = mechanism.loads[index].name; break;
    case ParameterOwner::friction: section = "friction", name = owner_of(mechanism, term.owner_kind, index); break;
    case ParameterOwner::force_element:
      section = section_of(mechanism.force_elements[index]);
      name = mechanism.force_elements[index].name;
      break;
  }
  return std::any_of(names.begin(), names.end(), [&](const std::string& excluded) {
    return excluded == section || excluded == name || excluded == section + "." + name;
  });
}

std::vector<std::string> list_excludable_names(const Mechanism& mechanism) {
  std::vector<std::string> names = {"friction", "loads", "springs", "dampers", "payloads", "counterweights", "discs"};
  const auto add = [&](const std::string& section, const std::string& name) {
    for (const std::string& candidate : {name, section + "." + name})
      if (std::find(names.begin(), names.end(), candidate) == names.end()) names.push_back(candidate);
  };
  for (std::size_t f = 0; f < mechanism.friction.size(); ++f)
    add("friction", owner_of(mechanism, ParameterOwner::friction, f));
  for (const Load& load : mechanism.loads) add("loads", load.name);
  for (const Spring& spring : mechanism.springs) add("springs", spring.name);
  for (const ForceElement& element : mechanism.force_elements) add(section_of(element), element.name);
  for (const Attachment& a : mechanism.attachments)
    add(a.kind == AttachmentKind::payload ? "payloads" : "counterweights", a.name);
  for (const Disc& disc : mechanism.discs) add("discs", disc.name);
  return names;
}

}  // namespace balance::conditions
