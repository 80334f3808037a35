#include "balance/synthesis/identification/probes.hpp"

#include "balance/foundation/numerics/random.hpp"
#include "balance/synthesis/identification/base_combinations.hpp"

#include <algorithm>
#include <map>
#include <string>

namespace balance::identification {

namespace {

constexpr int probes_per_unknown = 2, min_probes = 40, max_failures_per_probe = 20;
constexpr double angle_spread = 1.5;   ///< largest distance of a random angle from a measured one [rad]
constexpr double length_spread = 0.5;  ///< the same of a slide, in characteristic lengths
constexpr double rest_rate = 1e-3;     ///< of dry friction; random rates are of the order of one

void append_rows(MatrixX& all, const MatrixX& rows) {
  all.conservativeResize(all.rows() + rows.rows(), rows.cols());
  all.bottomRows(rows.rows()) = rows;
}

}  // namespace

ProbeRows probe(MotionEquations& equations, const std::vector<UnknownParameter>& unknowns,
                const std::vector<Channel>& channels, const std::vector<MeasuredStates>& states,
                const std::vector<MeasurementRecord>& records, std::uint64_t seed) {
  const Mechanism& mechanism = equations.mechanism();
  const int n = equations.degrees_of_freedom();
  const int axes = mechanism.space == SpaceKind::planar ? 2 : 3;
  const VectorX known = VectorX::Zero(equations.inertial_values().size());
  const auto U = static_cast<Eigen::Index>(unknowns.size());
  numerics::UniformRandom random(seed);
  ProbeRows out{MatrixX(0, U), MatrixX(0, U), MatrixX(0, U), MatrixX(0, U)};
  VectorX spread(n);
  for (int k = 0; k < n; ++k)
    spread[k] = is_length_coordinate(mechanism, equations.independent()[static_cast<std::size_t>(k)])
                    ? length_spread * characteristic_length(mechanism)
                    : angle_spread;
  const int count = std::max(min_probes, probes_per_unknown * static_cast<int>(U));
  MotionEquation equation;
  int failures = 0;
  for (int probes = 0; probes < count && failures < max_failures_per_probe * count;) {
    const MeasuredStates& part = states[static_cast<std::size_t>(random(0, static_cast<double>(states.size())))];
    const std::vector<std::string>& carried = records[static_cast<std::size_t>(part.record)].payloads;
    const auto rows_of = [&] { return make_regressor_rows(mechanism, equation, unknowns, known, carried, rest_rate); };
    const auto row = static_cast<Eigen::Index>(random(0, static_cast<double>(part.q.rows())));
    const VectorX near = part.q.row(row).transpose();
    const VectorX q = near + spread.cwiseProduct(random.sample_point(n)) / (1 + failures % 4);
    const VectorX dq = random.sample_normal(n), ddq = random.sample_normal(n), zero = VectorX::Zero(n);
    if (equations.evaluate(q, dq, ddq, part.time[row], equation).status != MotionStatus::done) {
      ++failures;
      continue;
    }
    const RegressorRows rows = rows_of();
    if (!rows.is_held) {
      ++failures;
      continue;
    }
    ++probes;
    MatrixX measured(static_cast<Eigen::Index>(channels.size()), U);
    for (std::size_t c = 0; c < channels.size(); ++c)
      measured.row(static_cast<Eigen::Index>(c)) =
          rows.columns.row(channels[c].signal.kind == MeasuredSignal::Kind::frame ? n + channels[c].signal.index
                                                                                  : channels[c].signal.index);
    append_rows(out.measured, measured);
    equation.frame = equation.shaking;
    const RegressorRows shaking = rows_of();
    append_rows(out.shaking_force, shaking.columns.middleRows(n, axes));
    append_rows(out.shaking_moment, shaking.columns.bottomRows(equations.frame_rows() - axes));
    if (equations.evaluate(q, zero, zero, part.time[row], equation).status != MotionStatus::done) continue;
    MatrixX weight = rows_of().columns.topRows(n);
    for (Eigen::Index k = 0; k < U; ++k)
      if (is_friction(unknowns[static_cast<std::size_t>(k)].kind)) weight.col(k).setZero();
    append_rows(out.weight, weight);
  }
  return out;
}

void clear_negligible_columns(const std::vector<UnknownParameter>& unknowns, ProbeRows& probes, MatrixX& rows) {
  std::map<std::string, double> largest;
  const VectorX norms = probes.measured.colwise().norm();
  for (std::size_t k = 0; k < unknowns.size(); ++k)
    largest[unknowns[k].unit] = std::max(largest[unknowns[k].unit], norms[static_cast<Eigen::Index>(k)]);
  for (std::size_t k = 0; k < unknowns.size(); ++k)
    if (const auto column = static_cast<Eigen::Index>(k);
        norms[column] <= negligible_column * largest[unknowns[k].unit]) {
      rows.col(column).setZero();
      probes.measured.col(column).setZero();
    }
}

}  // namespace balance::identification
