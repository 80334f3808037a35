#pragma once
/// A sampled quantity as a function of time: values between samples, crossings of a level, and peaks.

#include "balance/foundation/base/types.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance::comparison {

/// The side of a jump on which a value is taken.
enum class JumpSide { any, before, after };

/// First rows of the pieces without jumps among rows [begin, end), ascending. A jump is a step more than ten times as
/// steep as its neighbours.
/// @param time strictly ascending within the rows
std::vector<Eigen::Index> find_piece_begins(const VectorX& time, const Samples& samples, int first, int count,
                                            Eigen::Index begin, Eigen::Index end);

/// The polynomial of a step between two samples, in the time since the first of them divided by the step's length: a row
/// per power.
struct StepPolynomial {
  Eigen::Matrix<double, 4, Eigen::Dynamic> coefficients;
  double begin = 0, length = 1;

  VectorX value(double s) const;
  VectorX slope(double s) const;
  VectorX value_at_time(double time) const { return value((time - begin) / length); }
};

/// The polynomial of the step from row k − 1 to row k through the four nearest rows among [begin, end), or through all
/// of them if they are fewer, by Newton's divided differences.
/// @param time strictly ascending within the rows
/// @param shift of the rows that it passes through, as far as [begin, end) goes
StepPolynomial interpolate_step(const VectorX& time, const Eigen::Ref<const Samples>& samples, Eigen::Index begin,
                                Eigen::Index end, Eigen::Index k, Eigen::Index shift = 0);

/// A scalar, or a vector whose magnitude counts. Between samples it is the polynomial through the four nearest samples
/// of the same piece; pieces end at jumps. Two rows of equal time are both sides of a jump; where the samples have only
/// one row, a jump is recognised by its steepness and its place within the step is unknown.
class SampledCurve {
 public:
  /// @param time ascending; equal times belong to both sides of a jump
  /// @param samples one row per time, one column or the components of a vector
  SampledCurve(VectorX time, Samples samples);

  bool is_scalar() const { return samples_.cols() == 1; }
  double begin_time() const { return time_[0]; }
  double end_time() const { return time_[time_.size() - 1]; }
  /// Of the samples: the signed value of a scalar, the magnitude of a vector.
  const std::vector<double>& sampled_values() const { return values_; }
  const VectorX& sample_times() const { return time_; }

  enum class Gap {
    none,
    outside,  ///< before the first or after the last sample
    jump,     ///< strictly within a step with a jump, and no side is given
  };
  /// The signed value of a scalar, the magnitude of a vector.
  /// @param side any: at a jump the value after it. With a side, the piece on that side is continued up to the time
  std::pair<double, Gap> evaluate(double time, JumpSide side = JumpSide::any) const;

  /// All times at which the curve has this value, ascending. A curve that touches the level counts, a jump across it
  /// does not; where it stays on the level, only the first time does.
  std::vector<double> find_crossings(double level) const;

  enum class Extremum { peak, minimum, maximum };
  /// The time of the largest magnitude, or of the smallest or largest signed value: first the sample, among equal ones
  /// the first, then the extremum of the polynomials beside it, as far as its piece goes.
  double find_extremum(Extremum extremum) const;

 private:
  StepPolynomial polynomial(std::size_t piece, Eigen::Index k, Eigen::Index shift = 0) const {
    return interpolate_step(time_, samples_, piece_begins_[piece], piece_end(piece), k, shift);
  }
  bool is_beyond_error(std::size_t piece, Eigen::Index k, double s, const StepPolynomial& polynomial,
                       double distance) const;
  VectorX extrapolate(std::size_t piece, double time) const;
  double scalar_of(const VectorX& value) const { return is_scalar() ? value[0] : value.norm(); }
  std::vector<double> critical_points(const StepPolynomial& polynomial) const;
  std::optional<double> find_interior_extremum(const StepPolynomial& polynomial, double sign) const;
  Eigen::Index piece_end(std::size_t piece) const { return piece_begins_[piece + 1]; }

  VectorX time_;
  Samples samples_;
  std::vector<double> values_;
  std::vector<Eigen::Index> piece_begins_;  ///< ascending, then the number of rows
};

}  // namespace balance::comparison
