#include "balance/timing/law_slopes.hpp"

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

enum class ProfileSection { speeding_up, braking, sliding };

/// From one node to the next.
struct SensitivitySection {
  ProfileSection kind = ProfileSection::sliding;
  PathPoint middle, before, after;  ///< of its row
  double length = 0, time = 0;
  double ratio = 0;     ///< of d_dx to d_du in the middle
  VectorX forcing;      ///< −2 (slopes) / d_du there
  VectorX first, last;  ///< change of x at both ends
};

class DurationSensitivity {
 public:
  DurationSensitivity(const PathModel& model, const std::vector<double>& bounds, const TimeOptimalLaw& law,
                      const ConstraintGradient& slopes, Eigen::Index parameters)
      : model_(model), bounds_(bounds), slopes_(slopes), parameters_(parameters) {
    for (std::size_t k = 0; k + 1 < law.nodes.size(); ++k)
      if (law.nodes[k + 1].s > law.nodes[k].s) add(law.nodes[k], law.nodes[k + 1]);
  }

  VectorX run() {
    for (std::size_t i = 0; i < pieces_.size(); ++i)
      if (pieces_[i].kind != ProfileSection::braking) forwards(i);
    for (std::size_t i = pieces_.size(); i-- > 0;)
      if (pieces_[i].kind == ProfileSection::braking) backwards(i);
    VectorX total = VectorX::Zero(parameters_);
    for (const SensitivitySection& piece : pieces_) {
      const double x0 = piece.before.v * piece.before.v, x1 = piece.after.v * piece.after.v;
      const VectorX late = x1 > 0 ? VectorX(piece.last / x1) : VectorX(piece.first / x0);
      const VectorX early = x0 > 0 ? VectorX(piece.first / x0) : late;  // at rest both vanish, not their ratio
      total -= piece.time / 4 * (early + late);
    }
    return total;
  }

 private:
  void add(const TimeLawNode& from, const TimeLawNode& to) {
    const ProfilePoint a{from.t, from.s, from.v, from.u_after, -1}, b{to.t, to.s, to.v, to.u_before, -1};
    const ProfilePoint middle = interpolate_at_parameter(a, b, (a.s + b.s) / 2);
    SensitivitySection piece;
    piece.length = b.s - a.s;
    piece.time = b.t - a.t;
    piece.middle = {middle.s, middle.v, middle.u, from.row_after};
    if (piece.middle.row < 0) piece.middle.row = most_active_row(piece.middle);
    piece.before = {a.s, a.v, a.u, piece.middle.row};
    piece.after = {b.s, b.v, b.u, piece.middle.row};
    const ConstraintValue here = evaluate_constraint(model_, piece.middle);
    if (!here.is_velocity_limited) {
      piece.kind = here.d_du > 0 ? ProfileSection::speeding_up : ProfileSection::braking;
      piece.ratio = here.d_dx / here.d_du;
      piece.forcing = -2 / here.d_du * slopes_(piece.middle, here);
    }
    pieces_.push_back(std::move(piece));
  }

  int most_active_row(PathPoint moment) const {
    double most = -1;
    int row = 0;
    for (std::size_t r = 0; r < bounds_.size(); ++r) {
      moment.row = static_cast<int>(r);
      const double load = evaluate_constraint(model_, moment).magnitude / bounds_[r];
      if (load > most) most = load, row = static_cast<int>(r);
    }
    return row;
  }

  /// d_du δu + d_dx δx = −slopes, in the mean of both ends: δx' = 2 δu.
  void forwards(std::size_t i) {
    SensitivitySection& piece = pieces_[i];
    if (piece.kind == ProfileSection::sliding) {
      piece.first = sensitivity_on_velocity_bound(piece.before);
      piece.last = sensitivity_on_velocity_bound(piece.after);
      return;
    }
    if (i == 0) {
      piece.first = VectorX::Zero(parameters_);
    } else {
      const SensitivitySection& previous = pieces_[i - 1];
      piece.first = previous.kind == ProfileSection::braking ? sensitivity_at_switch_point(previous.after, piece.before)
                                                             : previous.last;
    }
    const double k = piece.length * piece.ratio;
    piece.last = ((1 - k) * piece.first + piece.length * piece.forcing) / (1 + k);
  }

  void backwards(std::size_t i) {
    SensitivitySection& piece = pieces_[i];
    const bool ends = i + 1 == pieces_.size();
    piece.last = ends ? VectorX(VectorX::Zero(parameters_)) : pieces_[i + 1].first;
    const double k = piece.length * piece.ratio;
    piece.first = ((1 + k) * piece.last - piece.length * piece.forcing) / (1 - k);
  }

  /// Where u does not change a row's magnitude, x alone keeps it.
  VectorX sensitivity_on_velocity_bound(const PathPoint& moment) const {
    const ConstraintValue here = evaluate_constraint(model_, moment);
    if (!(std::abs(here.d_dx) > 0)) return VectorX::Zero(parameters_);
    return -slopes_(moment, here) / here.d_dx;
  }

  /// Where braking ends and speeding up begins: on the ceiling, which one row or two make.
  VectorX sensitivity_at_switch_point(const PathPoint& before, const PathPoint& after) const {
    if (before.row == after.row) return sensitivity_on_velocity_bound(before);
    const ConstraintValue a = evaluate_constraint(model_, before), b = evaluate_constraint(model_, after);
    const double determinant = a.d_du * b.d_dx - b.d_du * a.d_dx;
    if (!(std::abs(determinant) > 0)) return VectorX::Zero(parameters_);
    return (b.d_du * slopes_(before, a) - a.d_du * slopes_(after, b)) / determinant;
  }

  const PathModel& model_;
  const std::vector<double>& bounds_;
  const ConstraintGradient& slopes_;
  Eigen::Index parameters_;
  std::vector<SensitivitySection> pieces_;
};

}  // namespace

VectorX differentiate_duration(const PathModel& model, const std::vector<double>& bounds, const TimeOptimalLaw& law,
                               const ConstraintGradient& slopes, Eigen::Index parameters) {
  return DurationSensitivity(model, bounds, law, slopes, parameters).run();
}

}  // namespace balance
