#include "balance/synthesis/certificate/virtual_linkage.hpp"

#include <algorithm>
#include <tuple>

namespace balance::certificate {
namespace {

/// Σ_j coefficient_j ω_j over the real unknowns ω.
using UnknownSum = std::map<int, LengthPolynomial>;

void add(UnknownSum& sum, const UnknownSum& other, const LengthPolynomial& factor) {
  for (const auto& [unknown, coefficient] : other) sum[unknown] += coefficient * factor;
}

class VirtualLinkageBuilder {
 public:
  VirtualLinkageBuilder(const PlanarLinkage& linkage, const LengthBox& box)
      : linkage_(linkage), box_(box), vectors_(linkage.vectors.size()) {}

  VirtualLinkageResult build() {
    if (!choose_pivots()) return {{}, "a loop has no link of its own whose length cannot vanish"};
    choose_scales();
    introduce_unknowns();
    solve_closures();
    VirtualLinkage result;
    result.unknowns = unknowns_;
    for (const FreeCounterweight& counterweight : linkage_.counterweights) {
      auto& corners = result.corners.emplace_back();
      for (const LengthPolynomial& corner : counterweight.corners)
        corners.push_back(scale_height(position(counterweight.body, corner)));
    }
    VectorSum moments;
    for (const CarriedMass& carried : linkage_.masses)
      moments = moments + position(carried.body, carried.place) * carried.mass;
    result.fixed_masses = scale_height(moments);
    result.fixed_size = linkage_.fixed_size.real() * result.fixed_masses.scale;
    for (std::size_t k = 1; k < vectors_; ++k) result.positive.push_back(scales_[k]);
    for (const LengthPolynomial& divisor : linkage_.divisors) {
      const auto form = positive_polar_form(divisor);
      if (!form) return {{}, "a link that several loops share may vanish"};
      result.positive.push_back(form->size);
    }
    return {std::move(result), {}};
  }

 private:
  LengthPolynomial constant(LengthPolynomial::Coefficient value) const {
    return LengthPolynomial::constant(linkage_.variables, value);
  }
  LengthPolynomial one() const { return constant(1); }

  VectorSum position(int body, const LengthPolynomial& place) const {
    const auto k = static_cast<std::size_t>(body);
    return linkage_.tree_joints[k] + VectorSum{{linkage_.directions[k], place}};
  }

  /// With a size that is positive on the box; none if it may vanish.
  std::optional<PolarForm> positive_polar_form(const LengthPolynomial& p) const {
    auto form = find_polar_form(p);
    if (!form) return {};
    const auto [low, high] = enclose_range(form->size, box_);
    if (high < 0) {
      form->unit = -form->unit;
      form->size = -form->size;
    } else if (!(low > 0)) {
      return {};
    }
    return form;
  }

  /// Its unknown is a multiple of one number: statics alone ask nothing of a force across gravity.
  bool is_half(int vector) const {
    return linkage_.gravity_direction && linkage_.vectors[static_cast<std::size_t>(vector)].slides_along == 0;
  }

  bool is_opposite(int vector) const {
    return std::any_of(linkage_.opposites.begin(), linkage_.opposites.end(), [vector](const auto& opposite) {
      return opposite.first == vector || opposite.second.other == vector;
    });
  }

  /// A closure of a half unknown must be real.
  bool can_be_pivot(int vector, const LoopClosure& closure) const {
    if (is_opposite(vector)) return false;
    const auto is_real_half = [&](const auto& link) {
      return is_half(link.first) && (link.second - link.second.real()).is_zero();
    };
    return !is_half(vector) || std::all_of(closure.links.begin(), closure.links.end(), is_real_half);
  }

  /// Every closure is solved for a vector that no other closure has, or none of those that are solved before it.
  bool choose_pivots() {
    const std::size_t count = linkage_.closures.size();
    pivot_forms_.resize(count);
    pivots_.assign(count, -1);
    std::vector<bool> is_remaining(count, true);
    for (bool is_first = true; order_.size() < count; is_first = false) {
      const std::size_t before = order_.size();
      const std::vector<bool> others = is_remaining;
      for (std::size_t j = 0; j < count; ++j) {
        if (!is_remaining[j] || !choose_pivot(j, is_first ? others : is_remaining)) continue;
        order_.push_back(j);
        is_remaining[j] = false;
      }
      if (!is_first && order_.size() == before) return false;
    }
    std::reverse(order_.begin(), order_.end());
    return true;
  }

  bool choose_pivot(std::size_t j, const std::vector<bool>& others) {
    std::tuple<bool, int, int> best_key;
    for (const auto& [vector, coefficient] : linkage_.closures[j].links) {
      const auto form = positive_polar_form(coefficient);
      if (!form || !can_be_pivot(vector, linkage_.closures[j])) continue;
      bool is_shared = false;
      for (std::size_t other = 0; other < others.size(); ++other)
        is_shared = is_shared || (other != j && others[other] && linkage_.closures[other].links.count(vector) > 0);
      if (is_shared) continue;
      const std::tuple<bool, int, int> key = pivot_key(vector);
      if (pivots_[j] >= 0 && !(key < best_key)) continue;
      best_key = key;
      pivots_[j] = vector;
      pivot_forms_[j] = *form;
    }
    return pivots_[j] >= 0;
  }

  /// A link between two joints; far from the ground, so that its own rows are the long ones; slides last.
  std::tuple<bool, int, int> pivot_key(int vector) const {
    const auto k = static_cast<std::size_t>(vector);
    if (linkage_.vectors[k].slides_along >= 0) return {true, 1, vector};
    const auto body = std::find(linkage_.directions.begin(), linkage_.directions.end(), vector);
    const VectorSum& joint = linkage_.tree_joints[static_cast<std::size_t>(body - linkage_.directions.begin())];
    return {linkage_.joint_places[k].size() != 1, -static_cast<int>(joint.size() - joint.count(0)), vector};
  }

  void choose_scales() {
    scales_.assign(vectors_, one());
    for (std::size_t k = 1; k < vectors_; ++k)
      if (linkage_.joint_places[k].size() == 1) {
        const auto form = positive_polar_form(linkage_.joint_places[k].front());
        if (form && !form->size.constant_value()) scales_[k] = form->size;
      }
    for (std::size_t j = 0; j < pivots_.size(); ++j)
      scales_[static_cast<std::size_t>(pivots_[j])] = pivot_forms_[j].size;
  }

  void introduce_unknowns() {
    solutions_.resize(vectors_);
    for (int k = 1; k < static_cast<int>(vectors_); ++k) {
      if (std::find(pivots_.begin(), pivots_.end(), k) != pivots_.end() || linkage_.opposites.count(k) > 0) continue;
      UnknownSum& own = solutions_[static_cast<std::size_t>(k)];
      if (is_half(k)) {
        own[unknowns_++] = constant(std::conj(*linkage_.gravity_direction));
        continue;
      }
      own[unknowns_++] = one();
      own[unknowns_++] = constant(imaginary_unit);
    }
    // the height of a mass on one is that of the other's conjugate, seen along gravity
    for (const auto& [vector, opposite] : linkage_.opposites) {
      const auto g = std::conj(*linkage_.gravity_direction);
      scales_[static_cast<std::size_t>(vector)] = scales_[static_cast<std::size_t>(opposite.other)];
      for (const auto& [unknown, coefficient] : solutions_[static_cast<std::size_t>(opposite.other)])
        solutions_[static_cast<std::size_t>(vector)][unknown] = coefficient.conjugate() * (opposite.factor * g * g);
    }
  }

  /// w of a pivot as a sum of the unknowns: −Σ L_k η_k / unit over the others, times their scales.
  void solve_closures() {
    for (const std::size_t j : order_) {
      const VectorSum& links = linkage_.closures[j].links;
      LengthPolynomial factor = one();
      for (const auto& [vector, coefficient] : links) {
        const LengthPolynomial& scale = scales_[static_cast<std::size_t>(vector)];
        if (vector != pivots_[j] && !(coefficient * factor).divide(scale)) factor = factor * scale;
      }
      const auto pivot = static_cast<std::size_t>(pivots_[j]);
      for (const auto& [vector, coefficient] : links) {
        if (vector == pivots_[j]) continue;
        const auto k = static_cast<std::size_t>(vector);
        const LengthPolynomial quotient = *(coefficient * factor).divide(scales_[k]);
        add(solutions_[pivot], solutions_[k], quotient * (-std::conj(pivot_forms_[j].unit)));
      }
      scales_[pivot] = scales_[pivot] * factor;
    }
  }

  /// Σ_k coefficient_k η_k in the unknowns, times the lengths by which it must be multiplied.
  VirtualHeight scale_height(VectorSum sum) const {
    sum.erase(0);  // does not move
    VirtualHeight height{one(), {}};
    for (const auto& [vector, coefficient] : sum) {
      const LengthPolynomial& scale = scales_[static_cast<std::size_t>(vector)];
      if (!(coefficient * height.scale).divide(scale)) height.scale = height.scale * scale;
    }
    UnknownSum unknowns;
    for (const auto& [vector, coefficient] : sum) {
      const auto k = static_cast<std::size_t>(vector);
      add(unknowns, solutions_[k], *(coefficient * height.scale).divide(scales_[k]));
    }
    for (int unknown = 0; unknown < unknowns_; ++unknown) {
      const auto found = unknowns.find(unknown);
      height.coefficients.push_back(found == unknowns.end() ? LengthPolynomial() : found->second.real());
    }
    return height;
  }

  const PlanarLinkage& linkage_;
  const LengthBox& box_;
  std::size_t vectors_;
  int unknowns_ = 0;
  std::vector<int> pivots_;  ///< per closure: the vector it is solved for
  std::vector<PolarForm> pivot_forms_;
  std::vector<std::size_t> order_;        ///< in which the closures are solved
  std::vector<LengthPolynomial> scales_;  ///< per vector: s_k
  std::vector<UnknownSum> solutions_;     ///< per vector: its w
};

}  // namespace

VirtualLinkageResult make_virtual_linkage(const PlanarLinkage& linkage, const LengthBox& box) {
  return VirtualLinkageBuilder(linkage, box).build();
}

}  // namespace balance::certificate
