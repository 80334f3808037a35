#pragma once
/// Efforts that are stated over time and act at every moment: cubics from knot to knot, cut by the actuators' limits. Private to control
/// and the rooms that open it up.

#include "balance/study/controller.hpp"

#include <array>
#include <vector>

namespace balance {

class EffortProfile {
 public:
  /// @param limit largest magnitude per actuator [N m or N]; empty: none
  /// @throws std::invalid_argument for a table without rows, or a spline through fewer than four
  EffortProfile(const EffortTable& table, const VectorX& limit);

  /// @param effort one per actuator [N m or N]
  void evaluate(double time, VectorX& effort) const;
  VectorX evaluate(double time) const;
  /// 1 where the limit cuts, else 0.
  VectorX saturation(double time) const;
  /// Σ |changes| of each effort between two times.
  VectorX total_variation(double from, double to) const;

  /// Where the efforts are not smooth: those of the table, and where limits begin and cease to cut. Increasing [s].
  const std::vector<double>& knots() const { return knots_; }

 private:
  /// c0 + c1 x + c2 x² + c3 x³ in the time x from the piece's start.
  using Cubic = std::array<double, 4>;
  struct Piece {
    double begin, end;
    std::vector<Cubic> efforts;
  };

  void make_pieces(const EffortTable& table);
  void add_saturation_knots();
  const Piece& find_piece(double time) const;
  double evaluate_unsaturated(const Piece& piece, std::size_t actuator, double time) const;
  double saturate(std::size_t actuator, double effort) const;
  static std::vector<double> find_monotone_intervals(const Cubic& cubic, double begin, double end);

  std::vector<Piece> pieces_;
  VectorX effort_limit_;
  std::vector<double> knots_;
};

}  // namespace balance
