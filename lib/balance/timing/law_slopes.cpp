#include "balance/timing/law_slopes.hpp"

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

enum class Arcs { speeding_up, braking, sliding };

/// From one node to the next.
struct Piece {
  Arcs kind = Arcs::sliding;
  PathMoment middle, before, after;  ///< of its row
  double length = 0, time = 0;
  double ratio = 0;     ///< of by_x to by_u in the middle
  VectorX push;         ///< −2 (slopes) / by_u there
  VectorX first, last;  ///< change of x at both ends
};

class DurationSlopes {
 public:
  DurationSlopes(const PathModel& model, const std::vector<double>& bounds, const FastestLaw& law,
                 const RowSlopes& slopes, Eigen::Index parameters)
      : model_(model), bounds_(bounds), slopes_(slopes), parameters_(parameters) {
    for (std::size_t k = 0; k + 1 < law.nodes.size(); ++k)
      if (law.nodes[k + 1].s > law.nodes[k].s) add(law.nodes[k], law.nodes[k + 1]);
  }

  VectorX run() {
    for (std::size_t i = 0; i < pieces_.size(); ++i)
      if (pieces_[i].kind != Arcs::braking) forwards(i);
    for (std::size_t i = pieces_.size(); i-- > 0;)
      if (pieces_[i].kind == Arcs::braking) backwards(i);
    VectorX total = VectorX::Zero(parameters_);
    for (const Piece& piece : pieces_) {
      const double x0 = piece.before.v * piece.before.v, x1 = piece.after.v * piece.after.v;
      const VectorX late = x1 > 0 ? VectorX(piece.last / x1) : VectorX(piece.first / x0);
      const VectorX early = x0 > 0 ? VectorX(piece.first / x0) : late;  // at rest both vanish, not their ratio
      total -= piece.time / 4 * (early + late);
    }
    return total;
  }

 private:
  void add(const TimedNode& from, const TimedNode& to) {
    const ArcNode a{from.t, from.s, from.v, from.u_after, -1}, b{to.t, to.s, to.v, to.u_before, -1};
    const ArcNode middle = between_at(a, b, (a.s + b.s) / 2);
    Piece piece;
    piece.length = b.s - a.s;
    piece.time = b.t - a.t;
    piece.middle = {middle.s, middle.v, middle.u, from.row_after};
    if (piece.middle.row < 0) piece.middle.row = fullest(piece.middle);
    piece.before = {a.s, a.v, a.u, piece.middle.row};
    piece.after = {b.s, b.v, b.u, piece.middle.row};
    const RowValue here = value_of_row(model_, piece.middle);
    if (!here.tangent) {
      piece.kind = here.by_u > 0 ? Arcs::speeding_up : Arcs::braking;
      piece.ratio = here.by_x / here.by_u;
      piece.push = -2 / here.by_u * slopes_(piece.middle, here);
    }
    pieces_.push_back(std::move(piece));
  }

  int fullest(PathMoment moment) const {
    double most = -1;
    int row = 0;
    for (std::size_t r = 0; r < bounds_.size(); ++r) {
      moment.row = static_cast<int>(r);
      const double load = value_of_row(model_, moment).magnitude / bounds_[r];
      if (load > most) most = load, row = static_cast<int>(r);
    }
    return row;
  }

  /// by_u δu + by_x δx = −slopes, in the mean of both ends: δx' = 2 δu.
  void forwards(std::size_t i) {
    Piece& piece = pieces_[i];
    if (piece.kind == Arcs::sliding) {
      piece.first = at_ceiling(piece.before);
      piece.last = at_ceiling(piece.after);
      return;
    }
    if (i == 0) {
      piece.first = VectorX::Zero(parameters_);
    } else {
      const Piece& previous = pieces_[i - 1];
      piece.first = previous.kind == Arcs::braking ? at_touch(previous.after, piece.before) : previous.last;
    }
    const double k = piece.length * piece.ratio;
    piece.last = ((1 - k) * piece.first + piece.length * piece.push) / (1 + k);
  }

  void backwards(std::size_t i) {
    Piece& piece = pieces_[i];
    const bool ends = i + 1 == pieces_.size();
    piece.last = ends ? VectorX(VectorX::Zero(parameters_)) : pieces_[i + 1].first;
    const double k = piece.length * piece.ratio;
    piece.first = ((1 + k) * piece.last - piece.length * piece.push) / (1 - k);
  }

  /// Where u does not change a row's magnitude, x alone keeps it.
  VectorX at_ceiling(const PathMoment& moment) const {
    const RowValue here = value_of_row(model_, moment);
    if (!(std::abs(here.by_x) > 0)) return VectorX::Zero(parameters_);
    return -slopes_(moment, here) / here.by_x;
  }

  /// Where braking ends and speeding up begins: on the ceiling, which one row or two make.
  VectorX at_touch(const PathMoment& before, const PathMoment& after) const {
    if (before.row == after.row) return at_ceiling(before);
    const RowValue a = value_of_row(model_, before), b = value_of_row(model_, after);
    const double determinant = a.by_u * b.by_x - b.by_u * a.by_x;
    if (!(std::abs(determinant) > 0)) return VectorX::Zero(parameters_);
    return (b.by_u * slopes_(before, a) - a.by_u * slopes_(after, b)) / determinant;
  }

  const PathModel& model_;
  const std::vector<double>& bounds_;
  const RowSlopes& slopes_;
  Eigen::Index parameters_;
  std::vector<Piece> pieces_;
};

}  // namespace

VectorX duration_slopes(const PathModel& model, const std::vector<double>& bounds, const FastestLaw& law,
                        const RowSlopes& slopes, Eigen::Index parameters) {
  return DurationSlopes(model, bounds, law, slopes, parameters).run();
}

}  // namespace balance
