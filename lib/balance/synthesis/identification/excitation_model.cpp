#include "balance/synthesis/identification/excitation_model.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance::identification {

namespace {

constexpr double assumed_angle_range = std::numbers::pi / 2;  ///< to both sides of the start, without a limit [rad]
constexpr double assumed_length_range = 0.5;                  ///< the same of a slide, in characteristic lengths
constexpr double difference_step = 1e-6;                      ///< [rad, m or per second]
constexpr double same_mode_tolerance = 1e-4;                  ///< of coordinates at the start [rad or m]
constexpr double acceleration_step = 1;                       ///< columns are affine in accelerations

std::vector<std::string> list_payloads(const Mechanism& mechanism) {
  std::vector<std::string> names;
  for (const Attachment& attachment : mechanism.attachments)
    if (attachment.kind == AttachmentKind::payload) names.push_back(attachment.name);
  return names;
}

}  // namespace

ExcitationModel::ExcitationModel(const Mechanism& mechanism, const ExcitationOptions& options)
    : options_(options),
      unknowns_(list_unknowns(mechanism, options.unknowns)),
      equations_(with_friction_coordinates(mechanism, unknowns_)),
      motion_(options.harmonics, options.period),
      payloads_(list_payloads(mechanism)),
      has_loops_(equations_.has_loops()) {
  const int n = freedoms();
  if (n == 0) throw ExcitationError("nothing can move: the mechanism has no degree of freedom");
  if (unknowns_.empty()) throw ExcitationError("there is nothing to identify: no body has mass, and nothing rubs");
  if (const auto actuators = static_cast<int>(mechanism.actuators.size()); actuators > 0 && actuators < n)
    throw ExcitationError(fmt::format("{} cannot make all {} degrees of freedom follow a prescribed motion",
                                      count_noun(actuators, "actuator", "actuators"), n));
  spec_.resize(static_cast<Eigen::Index>(unknowns_.size()));
  for (std::size_t k = 0; k < unknowns_.size(); ++k) spec_[static_cast<Eigen::Index>(k)] = unknowns_[k].spec_value;
  known_values_ = known_inertial_values(equations_.mechanism(), equations_.inertial_values(), unknowns_, payloads_);
  start_.setZero(n);
  for (int k = 0; k < n; ++k)
    for (const CoordinateValue& value : mechanism.assembly)
      if (value.coordinate == equations_.independent()[static_cast<std::size_t>(k)]) start_[k] = value.value;
  list_channels();
  set_limits(options.limits);
  const VectorX middle = this->middle(), half = half_range();
  for (int k = 0; k < n; ++k)
    if (std::abs(start_[k] - middle[k]) > half[k]) start_[k] = middle[k];
  weights_.setOnes(static_cast<Eigen::Index>(channels_.size()));
}

void ExcitationModel::list_channels() {
  using Kind = MeasuredSignal::Kind;
  const Mechanism& mechanism = equations_.mechanism();
  const auto unit = [&](CoordinateId c) { return is_length_coordinate(mechanism, c) ? "N" : "N m"; };
  const bool has_rows = has_effort_rows(mechanism, freedoms());
  for (int k = 0; k < freedoms(); ++k) {
    const CoordinateId coordinate = has_rows ? mechanism.actuators[static_cast<std::size_t>(k)]
                                             : equations_.independent()[static_cast<std::size_t>(k)];
    Channel channel;
    channel.name = mechanism.coordinates[static_cast<std::size_t>(coordinate)].name;
    channel.unit = unit(coordinate);
    channel.signal = {Kind::effort, k};
    channel.coordinate = coordinate;
    channels_.push_back(channel);
  }
  if (!options_.has_frame_sensor) return;
  const bool is_planar = mechanism.space == SpaceKind::planar;
  const char* const planar[] = {"fx", "fy", "m"};
  const char* const spatial[] = {"fx", "fy", "fz", "mx", "my", "mz"};
  for (int row = 0; row < equations_.frame_rows(); ++row) {
    Channel channel;
    channel.name = is_planar ? planar[row] : spatial[row];
    channel.unit = row < (is_planar ? 2 : 3) ? "N" : "N m";
    channel.signal = {Kind::frame, row};
    channels_.push_back(channel);
  }
}

void ExcitationModel::set_limits(const std::vector<ExcitationLimit>& given) {
  using Kind = ExcitationLimit::Kind;
  const Mechanism& mechanism = equations_.mechanism();
  const auto has = [&](Kind kind, int index) {
    return std::any_of(given.begin(), given.end(),
                       [&](const ExcitationLimit& one) { return one.kind == kind && one.index == index; });
  };
  std::vector<std::string> unlimited;
  std::size_t efforts = 0;
  for (const ExcitationLimit& limit : given) efforts += limit.kind == Kind::effort ? 1 : 0;
  const bool has_all_efforts = efforts >= std::max(mechanism.actuators.size(), static_cast<std::size_t>(freedoms()));
  for (int k = 0; k < freedoms(); ++k) {
    const CoordinateId c = equations_.independent()[static_cast<std::size_t>(k)];
    if (!has(Kind::position, c)) {
      const double range = is_length_coordinate(mechanism, c) ? assumed_length_range * characteristic_length(mechanism)
                                                              : assumed_angle_range;
      limits_.push_back({Kind::position, c, start_[k] - range, start_[k] + range});
      is_limit_given_.push_back(false);
    }
    if (!has(Kind::rate, c) && !has(Kind::acceleration, c) && !has_all_efforts)
      unlimited.push_back(mechanism.coordinates[static_cast<std::size_t>(c)].name);
  }
  if (!unlimited.empty())
    throw UnlimitedSpeedError(
        fmt::format("nothing limits the speed of {}: the faster, the more a motion shows. Expected a limit of rate or "
                    "acceleration of each, or of all efforts",
                    join_with_conjunction(unlimited, "and")));
  for (const ExcitationLimit& limit : given) {
    limits_.push_back(limit);
    is_limit_given_.push_back(true);
    const auto is_independent = [&] {
      return std::find(equations_.independent().begin(), equations_.independent().end(), limit.index) !=
             equations_.independent().end();
    };
    needs_positions_ = needs_positions_ || (limit.kind == Kind::position && !is_independent());
  }
}

VectorX ExcitationModel::middle() const {
  VectorX middle(freedoms());
  for (int k = 0; k < freedoms(); ++k)
    for (const ExcitationLimit& limit : limits_)
      if (limit.kind == ExcitationLimit::Kind::position &&
          limit.index == equations_.independent()[static_cast<std::size_t>(k)])
        middle[k] = (limit.lower + limit.upper) / 2;
  return middle;
}

VectorX ExcitationModel::half_range() const {
  VectorX half(freedoms());
  for (int k = 0; k < freedoms(); ++k)
    for (const ExcitationLimit& limit : limits_)
      if (limit.kind == ExcitationLimit::Kind::position &&
          limit.index == equations_.independent()[static_cast<std::size_t>(k)])
        half[k] = (limit.upper - limit.lower) / 2;
  return half;
}

Eigen::Index ExcitationModel::row_of(std::size_t channel) const {
  const MeasuredSignal& signal = channels_[channel].signal;
  return signal.kind == MeasuredSignal::Kind::frame ? freedoms() + signal.index : signal.index;
}

/// In the order of the actuators, of least norm if there are more than needed; without actuators of the coordinates.
VectorX ExcitationModel::actuator_efforts(const RegressorRows& rows) const {
  const Eigen::Index n = freedoms();
  const VectorX forces = rows.columns.topRows(n) * spec_ + rows.known.head(n);
  if (has_effort_rows(equations_.mechanism(), freedoms()) || equations_.mechanism().actuators.empty()) return forces;
  return numerics::CompleteOrthogonalDecomposition(rows.effort_map).solve(forces);
}

bool ExcitationModel::evaluate(const VectorX& q, const VectorX& dq, const VectorX& ddq, double time, double dry_rate,
                               State& state) {
  using Kind = ExcitationLimit::Kind;
  if (equations_.evaluate(q, dq, ddq, time, equation_).status != MotionStatus::done) return false;
  const Mechanism& mechanism = equations_.mechanism();
  state.rows = make_regressor_rows(mechanism, equation_, unknowns_, known_values_, payloads_, dry_rate);
  if (!state.rows.is_held) return false;
  state.rates = equation_.rates;
  state.mobility = has_loops_ ? equations_.mobility() : 1;
  const VectorX efforts = actuator_efforts(state.rows);
  VectorX positions;
  if (needs_positions_) positions = equations_.coordinates();
  state.limited.resize(static_cast<Eigen::Index>(limits_.size()));
  for (std::size_t l = 0; l < limits_.size(); ++l) {
    double& value = state.limited[static_cast<Eigen::Index>(l)];
    const int index = limits_[l].index;
    switch (limits_[l].kind) {
      case Kind::position: {
        const auto at = std::find(equations_.independent().begin(), equations_.independent().end(), index);
        value = at != equations_.independent().end() ? q[at - equations_.independent().begin()] : positions[index];
        break;
      }
      case Kind::rate: value = equation_.rates[index]; break;
      case Kind::acceleration: value = equation_.accelerations[index]; break;
      case Kind::effort: value = efforts[index]; break;
    }
  }
  return state.rows.columns.allFinite() && state.limited.allFinite();
}

/// Every motion is entered from the start, so that its assembly mode does not depend on motions that were tried before.
bool ExcitationModel::return_to_start() {
  const VectorX zero = VectorX::Zero(freedoms());
  const auto is_there = [&] {
    if (equations_.evaluate(start_, zero, zero, 0, equation_).status != MotionStatus::done) return false;
    const VectorX coordinates = equations_.coordinates();
    if (start_coordinates_.size() == 0) start_coordinates_ = coordinates;
    for (Eigen::Index c = 0; c < coordinates.size(); ++c)
      if (std::abs(std::remainder(coordinates[c] - start_coordinates_[c], 2 * std::numbers::pi)) > same_mode_tolerance)
        return false;
    return true;
  };
  if (is_there()) return true;
  equations_ = MotionEquations(Mechanism(equations_.mechanism()));
  return is_there();
}

std::optional<SampledMotion> ExcitationModel::sample(const MatrixX& coefficients, const VectorX& times,
                                                     double dry_rate) {
  const Eigen::Index S = times.size(), C = static_cast<Eigen::Index>(channels_.size());
  SampledMotion out;
  out.q = motion_.basis(times, 0) * coefficients.transpose();
  out.dq = motion_.basis(times, 1) * coefficients.transpose();
  out.ddq = motion_.basis(times, 2) * coefficients.transpose();
  out.columns.resize(static_cast<std::size_t>(S));
  out.measured.resize(S, C), out.channel_rates.setZero(S, C);
  out.limited.resize(S, static_cast<Eigen::Index>(limits_.size()));
  out.mobility.resize(S);
  out.is_fitted.assign(static_cast<std::size_t>(S), std::vector<bool>(static_cast<std::size_t>(C), true));
  if (has_loops_ && !return_to_start()) return {};
  State state;
  for (Eigen::Index s = 0; s < S; ++s) {
    if (!evaluate(out.q.row(s).transpose(), out.dq.row(s).transpose(), out.ddq.row(s).transpose(), times[s], dry_rate,
                  state))
      return {};
    MatrixX& columns = out.columns[static_cast<std::size_t>(s)];
    columns.resize(C, static_cast<Eigen::Index>(unknowns_.size()));
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      const auto i = static_cast<Eigen::Index>(c);
      const Eigen::Index row = row_of(c);
      columns.row(i) = weights_[i] * state.rows.columns.row(row);
      out.measured(s, i) = state.rows.columns.row(row).dot(spec_) + state.rows.known[row];
      if (channels_[c].coordinate < 0) continue;
      out.channel_rates(s, i) = state.rates[channels_[c].coordinate];
      const auto at_rest = [&](int coordinate) { return std::abs(state.rates[coordinate]) <= options_.rest_rate; };
      const std::vector<int>& dry = state.rows.dry[static_cast<std::size_t>(row)];
      out.is_fitted[static_cast<std::size_t>(s)][c] =
          !at_rest(channels_[c].coordinate) && std::none_of(dry.begin(), dry.end(), at_rest);
    }
    out.limited.row(s) = state.limited.transpose();
    out.mobility[s] = state.mobility;
  }
  return out;
}

std::optional<ExcitationModel::StateSlopes> ExcitationModel::differentiate(const SampledMotion& motion,
                                                                           Eigen::Index sample, const VectorX& times,
                                                                           double dry_rate, const MatrixX& factors) {
  const int n = freedoms();
  const MatrixX& columns = motion.columns[static_cast<std::size_t>(sample)];
  StateSlopes out{VectorX(3 * n), MatrixX(static_cast<Eigen::Index>(limits_.size()), 3 * n), VectorX(n)};
  State state;
  for (int k = 0; k < 3 * n; ++k) {
    VectorX q = motion.q.row(sample).transpose(), dq = motion.dq.row(sample).transpose(),
            ddq = motion.ddq.row(sample).transpose();
    const double step = k < 2 * n ? difference_step : acceleration_step;
    (k < n ? q[k] : k < 2 * n ? dq[k - n] : ddq[k - 2 * n]) += step;
    if (!evaluate(q, dq, ddq, times[sample], dry_rate, state)) return {};
    double change = 0;
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      const auto i = static_cast<Eigen::Index>(c);
      change += (weights_[i] * state.rows.columns.row(row_of(c)) - columns.row(i)).dot(factors.row(i));
    }
    out.information[k] = change / step;
    out.limited.col(k) = (state.limited - motion.limited.row(sample).transpose()) / step;
    if (k < n) out.mobility[k] = (state.mobility - motion.mobility[sample]) / step;
  }
  return out;
}

}  // namespace balance::identification
