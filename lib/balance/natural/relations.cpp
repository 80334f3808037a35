#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/natural/momentum.hpp"

#include <numeric>

namespace balance::natural {

namespace {

/// Angles of bodies, angles of discs and slides, and which of them stay together: everything linear that joints, couplings and
/// discs say about them.
class LinearDependencies {
 public:
  explicit LinearDependencies(const Mechanism& mechanism)
      : m_(mechanism), bodies_(static_cast<int>(mechanism.bodies.size())) {
    discs_ = static_cast<int>(m_.discs.size());
    const int count = bodies_ + discs_ + static_cast<int>(m_.coordinates.size());
    std::vector<Eigen::RowVectorXd> rows;
    const auto unit = [&](int k) { return Eigen::RowVectorXd(Eigen::RowVectorXd::Unit(count, k)); };
    rows.push_back(unit(ground));
    for (const Joint& joint : m_.joints)
      if (joint.type == JointType::prismatic || joint.type == JointType::fixed)
        rows.push_back(unit(joint.second) - unit(joint.first));
    for (std::size_t c = 0; c < m_.coordinates.size(); ++c) {
      const Joint& joint = m_.joints[static_cast<std::size_t>(m_.coordinates[c].joint)];
      if (m_.coordinates[c].kind == CoordinateKind::angle)
        rows.push_back(unit(coordinate(static_cast<int>(c))) - unit(joint.second) + unit(joint.first));
    }
    const auto sum = [&](const CoordinateCombination& followed) {
      Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(count);
      for (const CoordinateTerm& term : followed.terms) row += term.ratio * unit(coordinate(term.coordinate));
      return row;
    };
    for (const Coupling& coupling : m_.couplings)
      rows.push_back(unit(coordinate(coupling.follower)) - coupling.ratio * sum(coupling.leader));
    for (int d = 0; d < discs_; ++d) {
      const Disc& disc = m_.discs[static_cast<std::size_t>(d)];
      rows.push_back(unit(bodies_ + d) - unit(disc.body) - disc.ratio * sum(disc.follows));
    }
    MatrixX matrix(static_cast<Eigen::Index>(rows.size()), count);
    for (std::size_t r = 0; r < rows.size(); ++r) matrix.row(static_cast<Eigen::Index>(r)) = rows[r];
    const Eigen::FullPivLU<MatrixX> lu(matrix);
    free_ = lu.kernel();
    if (lu.dimensionOfKernel() == 0) free_ = MatrixX::Zero(count, 1);
  }

  int disc(int d) const { return bodies_ + d; }
  int coordinate(int c) const { return bodies_ + discs_ + c; }
  bool is_fixed(int k) const { return small(free_.row(k)); }
  bool is_moving_with(int a, int b) const { return small(free_.row(a) - free_.row(b)); }
  /// Whether a moves ratio times as b.
  bool is_proportional(int a, int b, double& ratio) const {
    const double size = free_.row(b).squaredNorm();
    if (is_fixed(b)) return false;
    ratio = free_.row(a).dot(free_.row(b)) / size;
    return small(free_.row(a) - ratio * free_.row(b));
  }

 private:
  static bool small(const Eigen::RowVectorXd& row) { return row.lpNorm<Eigen::Infinity>() < 1e-9; }

  const Mechanism& m_;
  int bodies_, discs_;
  MatrixX free_;  ///< all that the linear equations leave free
};

class VelocityRelationBuilder {
 public:
  VelocityRelationBuilder(const Mechanism& mechanism, const NaturalModel& model)
      : m_(mechanism), model_(model), together_(mechanism), moving_(model.basic.moving), places_(model.start) {}

  Eigen::MatrixXcd run() {
    for (std::size_t b = 1; b < m_.bodies.size(); ++b) extra_points(b);
    directions();
    slides();
    Eigen::MatrixXcd out(static_cast<Eigen::Index>(rows_.size()), width());
    for (std::size_t r = 0; r < rows_.size(); ++r) out.row(static_cast<Eigen::Index>(r)) = rows_[r];
    return out;
  }

 private:
  using RowC = Eigen::RowVectorXcd;

  Eigen::Index width() const { return moving_ + static_cast<Eigen::Index>(m_.discs.size()); }

  /// A form's velocity in terms of the points'.
  RowC velocity(const AffineForm& form) const {
    RowC row = RowC::Zero(width());
    for (const PointTerm& term : form.terms)
      if (term.point < moving_) row[term.point] += term.weight;
    return row;
  }

  void add(const RowC& row) {
    if (max_abs(row) > 1e-12) rows_.push_back(row);
  }

  void extra_points(std::size_t b) {
    const std::vector<BodyPoint>& points = model_.basic.bodies[b].points;
    for (std::size_t k = 2; k < points.size(); ++k)
      add(velocity(model_.bodies[b].place(points[k].position) - AffineForm{{}, {{points[k].point, 1}}}));
  }

  /// Directions of bodies and of discs; each is tied to the first that it stays together with.
  void directions() {
    struct Direction {
      int index;
      RowC velocity;
      Complex now;
    };
    std::vector<Direction> all;
    for (std::size_t b = 1; b < m_.bodies.size(); ++b)
      all.push_back(
          {static_cast<int>(b), velocity(model_.bodies[b].direction), model_.bodies[b].direction.at(places_)});
    for (std::size_t d = 0; d < m_.discs.size(); ++d) {
      RowC rim = RowC::Zero(width());
      rim[moving_ + static_cast<Eigen::Index>(d)] = 1;
      all.push_back(
          {together_.disc(static_cast<int>(d)), rim, make_unit_complex(model_.rotors[d].angle.at(places_.scalars))});
    }
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (together_.is_fixed(all[k].index)) {
        add(all[k].velocity);
        continue;
      }
      for (std::size_t j = 0; j < k; ++j) {
        if (!together_.is_moving_with(all[k].index, all[j].index)) continue;
        add(all[k].velocity - all[k].now / all[j].now * all[j].velocity);
        break;
      }
    }
  }

  /// Gaps s u along directions that stay together, of slides that move in proportion: s = r s₀ + c.
  void slides() {
    struct Slide {
      int index, body;
      AffineForm gap;
      Complex axis;  ///< in the world, now
      double length;
    };
    std::vector<Slide> all;
    for (std::size_t c = 0; c < m_.coordinates.size(); ++c) {
      if (m_.coordinates[c].kind == CoordinateKind::angle) continue;
      const ConstraintRow& row = model_.coordinates[c].slide;
      all.push_back({together_.coordinate(static_cast<int>(c)),
                     m_.joints[static_cast<std::size_t>(m_.coordinates[c].joint)].first, row.right,
                     row.left.at(places_), row.value(places_)});
    }
    for (std::size_t k = 0; k < all.size(); ++k) {
      const Slide& slide = all[k];
      const AffineForm direction = model_.bodies[static_cast<std::size_t>(slide.body)].direction;
      const Complex along = slide.axis / direction.at(places_);
      if (together_.is_fixed(slide.index)) {
        add(velocity(slide.gap) - slide.length * along * velocity(direction));
        continue;
      }
      for (std::size_t j = 0; j < k; ++j) {
        double ratio = 0;
        const Slide& other = all[j];
        if (!together_.is_moving_with(slide.body, other.body) ||
            !together_.is_proportional(slide.index, other.index, ratio))
          continue;
        const double rest = slide.length - ratio * other.length;
        add(velocity(slide.gap) - ratio * slide.axis / other.axis * velocity(other.gap) -
            rest * along * velocity(direction));
        break;
      }
    }
  }

  const Mechanism& m_;
  const NaturalModel& model_;
  LinearDependencies together_;
  int moving_;
  NaturalCoordinates places_;
  std::vector<RowC> rows_;
};

}  // namespace

Eigen::MatrixXcd velocity_relations(const Mechanism& mechanism, const NaturalModel& model) {
  return VelocityRelationBuilder(mechanism, model).run();
}

}  // namespace balance::natural
