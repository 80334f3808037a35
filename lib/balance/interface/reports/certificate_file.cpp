#include "balance/interface/reports/certificate_file.hpp"

#include "balance/interface/files/json.hpp"
#include "balance/interface/reports/conditions_sections.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace balance::reports {
namespace {

using namespace certificate;

/// Version 2 is that of conditions of moments, with heights that are quadratic in places.
constexpr int format_version = 1, moment_format_version = 2;
constexpr std::array<const char*, PlacedHeight::count> function_names{"1", "x", "y", "x2+y2", "ratio"};

/// Hexadecimal, so that readers with exact arithmetic lose nothing: "-0x1.8p+1".
std::string exact(double value) {
  std::array<char, 64> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), std::abs(value), std::chars_format::hex);
  return (std::signbit(value) ? "-0x" : "0x") + std::string(digits.data(), end.ptr);
}

class CertificateFormatter {
 public:
  explicit CertificateFormatter(const DesignReport& report) : report_(report), bound_(*report.length_bound) {}

  std::string format(const std::string& objective, const files::Provenance& description) const {
    const Json head = {{"format", "balance-certificate"},
                       {"version", has_moments() ? moment_format_version : format_version},
                       {"program", description.version},
                       {"command", description.command_line},
                       {"mechanism", description.title},
                       {"spec", description.spec_text},
                       {"objective", objective},
                       {"goal", goals_json(report_.outcome.conditions.goals)},
                       {"unit", "kg"},
                       {"impossible", bound_.is_impossible()},
                       {"lower_bound", bound_.is_impossible() ? Json() : Json(exact(bound_.lower_bound))},
                       {"best", best()},
                       {"covers", bound_.geometries},
                       {"not_covered", bound_.uncovered}};
    std::string text = "{\n";
    for (const auto& [key, value] : head.items()) text += member("", key, value) + ",\n";
    text += "\"geometries\": [";
    for (std::size_t g = 0; g < bound_.proof.size(); ++g) text += (g > 0 ? ", " : "") + geometry(bound_.proof[g]);
    return text + "]\n}\n";
  }

 private:
  bool has_moments() const {
    return std::any_of(bound_.proof.begin(), bound_.proof.end(),
                       [](const GeometryProof& proof) { return proof.geometry.linkage.balances_moments; });
  }

  static std::string member(const std::string& indent, const std::string& key, const Json& value) {
    return indent + Json(key).dump() + ": " + value.dump();
  }
  /// One element a line.
  static std::string lines(const std::string& key, const std::vector<Json>& elements) {
    std::string text = "  " + Json(key).dump() + ": [";
    for (std::size_t i = 0; i < elements.size(); ++i) text += (i > 0 ? ",\n    " : "\n    ") + elements[i].dump();
    return text + "]";
  }

  const std::string& name(int number) const { return report_.free_numbers[static_cast<std::size_t>(number)].key_path; }

  /// Null without a design.
  Json best() const {
    if (bound_.design.size() == 0) return {};
    Json values = Json::object();
    for (Eigen::Index i = 0; i < bound_.design.size(); ++i) values[name(static_cast<int>(i))] = bound_.design[i];
    return {{"value", bound_.best}, {"free_numbers", values}};
  }

  /// Terms: coefficient, then the exponents that are not 0.
  Json polynomial(const LengthPolynomial& p) const {
    Json terms = Json::array();
    for (const auto& [exponents, coefficient] : p.terms()) {
      Json powers = Json::object();
      for (std::size_t i = 0; i < exponents.size(); ++i)
        if (exponents[i] != 0) powers[name(static_cast<int>(i))] = exponents[i];
      terms.push_back({exact(coefficient.real()), powers});
    }
    return terms;
  }

  Json height(const VirtualHeight& height) const {
    Json coefficients = Json::array();
    for (const LengthPolynomial& p : height.coefficients) coefficients.push_back(polynomial(p));
    return {{"scale", polynomial(height.scale)}, {"coefficients", coefficients}};
  }

  /// The functions of a place and a ratio, and the free numbers that these are; null: none.
  Json placed(const PlacedHeight& height, const std::array<int, 3>& numbers) const {
    Json functions = Json::object(), coordinates = Json::array();
    for (std::size_t f = 0; f < PlacedHeight::count; ++f) {
      if (height.coefficients[f].empty()) continue;
      Json coefficients = Json::array();
      for (const LengthPolynomial& p : height.coefficients[f]) coefficients.push_back(polynomial(p));
      functions[function_names[f]] = coefficients;
    }
    for (const int number : numbers) coordinates.push_back(number < 0 ? Json() : Json(name(number)));
    return {{"scale", polynomial(height.scale)}, {"functions", functions}, {"coordinates", coordinates}};
  }

  /// With moments also places and ratios.
  Json lengths(const LengthGeometry& geometry) const {
    Json intervals = Json::object();
    const BoxProgram program(geometry.linkage, geometry.dual, geometry.conditions);
    std::vector<int> numbers = program.lengths();
    if (geometry.linkage.balances_moments) {
      for (const FreeCounterweight& counterweight : geometry.linkage.counterweights)
        for (const int number : counterweight.place_numbers)
          if (number >= 0) numbers.push_back(number);
      for (const int number : list_free_ratios(geometry.linkage)) numbers.push_back(number);
    }
    for (const int length : numbers)
      intervals[name(length)] = {exact(geometry.box.lower[length]), exact(geometry.box.upper[length])};
    return intervals;
  }

  Json counterweight(const LengthGeometry& geometry, std::size_t i) const {
    const FreeCounterweight& counterweight = geometry.linkage.counterweights[i];
    Json result = {{"name", counterweight.name}, {"mass", {exact(counterweight.lower), exact(counterweight.upper)}}};
    if (geometry.linkage.balances_moments) {
      result["placed"] =
          placed(geometry.dual.placed[i],
                 {counterweight.place_numbers[0], counterweight.place_numbers[1], counterweight.spin.ratio_number});
      return result;
    }
    Json corners = Json::array();
    for (const VirtualHeight& corner : geometry.dual.corners[i]) corners.push_back(height(corner));
    result["corners"] = corners;
    return result;
  }

  std::vector<Json> inertias(const LengthGeometry& geometry) const {
    std::vector<Json> all;
    for (std::size_t i = 0; i < geometry.linkage.inertias.size(); ++i) {
      const FreeInertia& inertia = geometry.linkage.inertias[i];
      all.push_back({{"name", inertia.name},
                     {"inertia", {exact(inertia.lower), exact(inertia.upper)}},
                     {"placed", placed(geometry.dual.inertias[i], {-1, -1, inertia.spin.ratio_number})}});
    }
    return all;
  }

  std::string geometry(const GeometryProof& proof) const {
    const LengthGeometry& geometry = proof.geometry;
    Json substitution = Json::object();
    for (const auto& [number, value] : geometry.substitution) substitution[name(number)] = polynomial(value);
    std::vector<Json> counterweights, conditions, boxes;
    for (std::size_t i = 0; i < geometry.linkage.counterweights.size(); ++i)
      counterweights.push_back(counterweight(geometry, i));
    for (const LengthCondition& condition : geometry.conditions)
      conditions.push_back({{"polynomial", polynomial(condition.polynomial)}, {"is_zero", condition.is_equality}});
    for (const ProofStep& step : proof.steps) boxes.push_back(box(step, geometry));
    std::string text = "{\n" + member("  ", "name", geometry.name) + ",\n";
    text += member("  ", "substitution", substitution) + ",\n";
    text += member("  ", "lengths", lengths(geometry)) + ",\n";
    text += member("  ", "unknowns", geometry.dual.unknowns) + ",\n";
    text += member("  ", "own_mass", polynomial(geometry.linkage.fixed_size.real())) + ",\n";
    text += member("  ", "fixed_masses", height(geometry.dual.fixed_masses)) + ",\n";
    text += lines("counterweights", counterweights) + ",\n";
    if (geometry.linkage.balances_moments) text += lines("inertias", inertias(geometry)) + ",\n";
    text += lines("conditions", conditions) + ",\n";
    return text + lines("boxes", boxes) + "}";
  }

  Json box(const ProofStep& step, const LengthGeometry& geometry) const {
    switch (step.kind) {
      case ProofStep::Kind::split: return {{"split", name(step.length)}, {"at", exact(step.at)}};
      case ProofStep::Kind::excluded: return {{"excluded_by", step.condition}};
      case ProofStep::Kind::bounded: break;
    }
    const BoxCertificate& multipliers = step.multipliers;
    const auto column = [&](Eigen::Index index) {
      Json values = Json::array();
      for (Eigen::Index row = 0; row < multipliers.multipliers.rows(); ++row)
        values.push_back(exact(multipliers.multipliers(row, index)));
      return values;
    };
    Json affine = Json::array(), w = Json::array(), sigma = Json::object(), kappa = Json::object();
    for (const int length : multipliers.affine) affine.push_back(name(length));
    for (int j = 0; j < multipliers.unknowns; ++j) w.push_back(column(j));
    const std::size_t counterweights = geometry.linkage.counterweights.size();
    for (std::size_t i = 0; i < counterweights; ++i)
      if (multipliers.limit_index[i] >= 0)
        sigma[geometry.linkage.counterweights[i].name] = {
            {"is_upper_used", multipliers.mass_limits[i].is_upper_used},
            {"value", column(multipliers.unknowns + multipliers.limit_index[i])}};
    for (std::size_t c = 0; c < multipliers.conditions.size(); ++c)
      if (multipliers.condition_multipliers[static_cast<Eigen::Index>(c)] != 0)
        kappa[std::to_string(multipliers.conditions[c])] =
            exact(multipliers.condition_multipliers[static_cast<Eigen::Index>(c)]);
    Json result = {{"bound", exact(step.bound)}, {"affine", affine}, {"w", w}, {"sigma", sigma}, {"kappa", kappa}};
    if (!geometry.linkage.balances_moments) return result;
    result["inertia_sigma"] = Json::array();
    for (std::size_t i = counterweights; i < multipliers.limit_index.size(); ++i)
      result["inertia_sigma"].push_back(column(multipliers.unknowns + multipliers.limit_index[i]));
    return result;
  }

  const DesignReport& report_;
  const LengthBound& bound_;
};

}  // namespace

std::string format_certificate(const DesignReport& report, const std::string& objective,
                               const files::Provenance& description) {
  return CertificateFormatter(report).format(objective, description);
}

}  // namespace balance::reports
