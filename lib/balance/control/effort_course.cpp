#include "balance/control/effort_course.hpp"

#include "balance/motion/spline.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance {

EffortProfile::EffortProfile(const EffortTable& table, const VectorX& limit) : effort_limit_(limit) {
  if (table.time.empty() || table.effort.size() != table.time.size())
    throw std::invalid_argument("efforts over time need one row per time");
  make_pieces(table);
  knots_ = table.time;
  if (effort_limit_.size() > 0) add_saturation_knots();
  std::sort(knots_.begin(), knots_.end());
}

void EffortProfile::make_pieces(const EffortTable& table) {
  const std::size_t rows = table.time.size();
  const Eigen::Index actuators = table.effort.front().size();
  Samples values(static_cast<Eigen::Index>(rows), actuators), curvature = Samples::Zero(values.rows(), actuators);
  Samples slope = curvature;
  for (Eigen::Index k = 0; k < values.rows(); ++k) values.row(k) = table.effort[static_cast<std::size_t>(k)];
  const bool curved = table.interpolation == EffortTable::Interpolation::spline && rows > 1;
  if (curved) {
    const CubicSpline spline(table.time, values, SplineEnd::not_a_knot);
    VectorX value(actuators), first(actuators), second(actuators);
    for (Eigen::Index k = 0; k < values.rows(); ++k) {
      spline.at(table.time[static_cast<std::size_t>(k)], value, first, second);
      slope.row(k) = first;
      curvature.row(k) = second;
    }
  }
  for (std::size_t k = 0; k + 1 < rows; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const double h = table.time[k + 1] - table.time[k];
    Piece piece{table.time[k], table.time[k + 1], {}};
    for (Eigen::Index a = 0; a < actuators; ++a) {
      const double rise = (values(row + 1, a) - values(row, a)) / h;
      const double bend = curvature(row, a) / 2, twist = (curvature(row + 1, a) - curvature(row, a)) / (6 * h);
      piece.efforts.push_back({values(row, a), curved ? slope(row, a) : rise, bend, twist});
    }
    pieces_.push_back(std::move(piece));
  }
  if (!pieces_.empty()) return;
  Piece constant{table.time[0], table.time[0], {}};
  for (Eigen::Index a = 0; a < actuators; ++a) constant.efforts.push_back({values(0, a), 0, 0, 0});
  pieces_.push_back(std::move(constant));
}

/// Bisection on every monotone stretch: each has one crossing of ±limit at most.
void EffortProfile::add_saturation_knots() {
  constexpr int max_bisections = 60;
  for (const Piece& piece : pieces_)
    for (std::size_t a = 0; a < piece.efforts.size(); ++a) {
      const std::vector<double> ends = find_monotone_intervals(piece.efforts[a], piece.begin, piece.end);
      for (std::size_t k = 0; k + 1 < ends.size(); ++k)
        for (const double level :
             {effort_limit_[static_cast<Eigen::Index>(a)], -effort_limit_[static_cast<Eigen::Index>(a)]}) {
          double low = ends[k], high = ends[k + 1];
          const bool begins_above = evaluate_unsaturated(piece, a, low) > level;
          if (begins_above == (evaluate_unsaturated(piece, a, high) > level)) continue;
          for (int turn = 0; turn < max_bisections; ++turn) {
            const double middle = (low + high) / 2;
            ((evaluate_unsaturated(piece, a, middle) > level) == begins_above ? low : high) = middle;
          }
          if (high > piece.begin && high < piece.end) knots_.push_back(high);
        }
    }
}

const EffortProfile::Piece& EffortProfile::find_piece(double time) const {
  const auto next = std::upper_bound(pieces_.begin(), pieces_.end(), time,
                                     [](double t, const Piece& piece) { return t < piece.begin; });
  return next == pieces_.begin() ? pieces_.front() : *(next - 1);
}

/// Held before the first and behind the last row.
double EffortProfile::evaluate_unsaturated(const Piece& piece, std::size_t actuator, double time) const {
  const Cubic& c = piece.efforts[actuator];
  const double x = std::clamp(time, piece.begin, piece.end) - piece.begin;
  return c[0] + x * (c[1] + x * (c[2] + x * c[3]));
}

double EffortProfile::saturate(std::size_t actuator, double effort) const {
  if (effort_limit_.size() == 0) return effort;
  const double limit = effort_limit_[static_cast<Eigen::Index>(actuator)];
  return std::clamp(effort, -limit, limit);
}

/// The ends, and between them where the derivative is zero.
std::vector<double> EffortProfile::find_monotone_intervals(const Cubic& c, double begin, double end) {
  std::vector<double> at{begin};
  const double a = 3 * c[3], half = c[2], root = half * half - a * c[1];
  if (root > 0) {
    // of a x² + 2 half x + c1, without cancellation
    const double q = -(half + std::copysign(std::sqrt(root), half));
    for (const double x : {q / a, c[1] / q})
      if (std::isfinite(x) && x > 0 && x < end - begin) at.push_back(begin + x);
  }
  at.push_back(end);
  std::sort(at.begin(), at.end());
  return at;
}

void EffortProfile::evaluate(double time, VectorX& effort) const {
  const Piece& piece = find_piece(time);
  for (std::size_t a = 0; a < piece.efforts.size(); ++a)
    effort[static_cast<Eigen::Index>(a)] = saturate(a, evaluate_unsaturated(piece, a, time));
}

VectorX EffortProfile::evaluate(double time) const {
  VectorX effort(static_cast<Eigen::Index>(pieces_.front().efforts.size()));
  evaluate(time, effort);
  return effort;
}

VectorX EffortProfile::saturation(double time) const {
  const Piece& piece = find_piece(time);
  VectorX out = VectorX::Zero(static_cast<Eigen::Index>(piece.efforts.size()));
  for (std::size_t a = 0; a < piece.efforts.size(); ++a) {
    const double effort = evaluate_unsaturated(piece, a, time);
    if (saturate(a, effort) != effort) out[static_cast<Eigen::Index>(a)] = 1;
  }
  return out;
}

VectorX EffortProfile::total_variation(double from, double to) const {
  VectorX sum = VectorX::Zero(static_cast<Eigen::Index>(pieces_.front().efforts.size()));
  for (auto piece = pieces_.begin() + (&find_piece(from) - pieces_.data()); piece != pieces_.end(); ++piece) {
    if (piece->begin >= to) break;
    const double begin = std::max(from, piece->begin), end = std::min(to, piece->end);
    if (!(begin < end)) continue;
    for (std::size_t a = 0; a < piece->efforts.size(); ++a) {
      double last = saturate(a, evaluate_unsaturated(*piece, a, begin));
      for (const double turn : find_monotone_intervals(piece->efforts[a], piece->begin, piece->end)) {
        if (turn <= begin) continue;
        const double next = saturate(a, evaluate_unsaturated(*piece, a, std::min(turn, end)));
        sum[static_cast<Eigen::Index>(a)] += std::abs(next - last);
        last = next;
        if (turn >= end) break;
      }
    }
  }
  return sum;
}

}  // namespace balance
