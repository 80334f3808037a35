#include "balance/synthesis/certificate/virtual_linkage.hpp"

#include <algorithm>
#include <array>
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
    if (linkage_.balances_forces) {
      introduce_unknowns();
      solve_closures();
    }
    if (linkage_.balances_moments) introduce_form();
    VirtualLinkage result;
    result.unknowns = unknowns_;
    if (linkage_.balances_moments)
      place_heights(result);
    else
      list_corner_heights(result);
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
  void list_corner_heights(VirtualLinkage& result) const {
    for (const FreeCounterweight& counterweight : linkage_.counterweights) {
      auto& corners = result.corners.emplace_back();
      for (const LengthPolynomial& corner : counterweight.corners)
        corners.push_back(scale_height(position(counterweight.body, corner)));
    }
    result.fixed_masses = scale_height(sum_fixed_masses());
  }

  VectorSum sum_fixed_masses() const {
    VectorSum moments;
    for (const CarriedMass& carried : linkage_.masses)
      moments = moments + position(carried.body, carried.place) * carried.mass;
    return moments;
  }

  void place_heights(VirtualLinkage& result) const {
    for (const FreeCounterweight& counterweight : linkage_.counterweights)
      result.placed.push_back(place_height(counterweight));
    for (const FreeInertia& inertia : linkage_.inertias) {
      MomentTerms terms;
      add_spin(inertia.spin, terms);
      result.inertias.push_back(scale_height({}, terms));
    }
    MomentTerms terms;
    for (const CarriedMass& carried : linkage_.masses)
      terms.push_back({PlacedHeight::constant, position(carried.body, carried.place),
                       position(carried.body, carried.place), carried.mass});
    add_spin({linkage_.fixed_spin, {}, -1}, terms);
    const PlacedHeight fixed = scale_height({{PlacedHeight::constant, sum_fixed_masses()}}, terms);
    result.fixed_masses = {fixed.scale, fixed.coefficients[PlacedHeight::constant]};
  }

  PlacedHeight place_height(const FreeCounterweight& counterweight) const {
    const auto k = static_cast<std::size_t>(counterweight.body);
    const int direction = linkage_.directions[k];
    const VectorSum origin = position(counterweight.body, counterweight.origin);
    const VectorSum x{{direction, constant(linkage_.turns[k])}},
        y{{direction, constant(linkage_.turns[k] * imaginary_unit)}};
    ForceTerms forces{{PlacedHeight::constant, origin}};
    MomentTerms moments{{PlacedHeight::constant, origin, origin, one()}};
    const std::array<std::pair<std::size_t, VectorSum>, 2> axes{{{PlacedHeight::x, x}, {PlacedHeight::y, y}}};
    bool is_free = false;
    for (std::size_t i = 0; i < 2; ++i) {
      if (counterweight.place_numbers[i] < 0) continue;
      forces.emplace_back(axes[i]);
      moments.push_back({axes[i].first, origin, axes[i].second, constant(2)});
      is_free = true;
    }
    if (is_free) moments.push_back({PlacedHeight::square, x, x, one()});
    add_spin(counterweight.spin, moments);
    return scale_height(forces, moments);
  }

  /// f · Σ_k coefficient_k η_k.
  using ForceTerms = std::vector<std::pair<std::size_t, VectorSum>>;
  /// f · factor · Re Σ_uv ā_u b_v G_uv.
  struct MomentTerm {
    std::size_t function = PlacedHeight::constant;
    VectorSum a, b;
    LengthPolynomial factor;
  };
  using MomentTerms = std::vector<MomentTerm>;

  void add_spin(const RatioSpin& spin, MomentTerms& terms) const {
    for (const auto& [function, sum] :
         {std::pair{PlacedHeight::constant, &spin.constant}, std::pair{PlacedHeight::ratio, &spin.per_ratio}})
      for (const auto& [vector, factor] : *sum) {
        const VectorSum direction{{vector, one()}};
        if (!factor.is_zero()) terms.push_back({function, direction, direction, factor});
      }
  }

  bool is_real(int vector) const {
    return vector == 0 || linkage_.vectors[static_cast<std::size_t>(vector)].slides_along == 0;
  }
  bool is_pivot(int vector) const { return std::find(pivots_.begin(), pivots_.end(), vector) != pivots_.end(); }

  /// A real and an imaginary part per pair of vectors that are no pivots, as far as they are free.
  void introduce_form() {
    for (int u = 0; u < static_cast<int>(vectors_); ++u)
      for (int v = u; v < static_cast<int>(vectors_); ++v) {
        if (is_pivot(u) || is_pivot(v)) continue;
        const bool has_real = !(is_real(u) && is_real(v)), has_imaginary = u != v;
        const int first = unknowns_;
        unknowns_ += (has_real ? 1 : 0) + (has_imaginary ? 1 : 0);
        form_[{u, v}] = {has_real ? first : -1, has_imaginary ? unknowns_ - 1 : -1};
      }
  }

  /// Replaces the pivots of all sums by the other vectors. @return the length by which the sums have been multiplied
  LengthPolynomial eliminate_pivots(std::vector<VectorSum>& sums) const {
    LengthPolynomial denominator = one();
    for (auto j = order_.rbegin(); j != order_.rend(); ++j) {
      const int pivot = pivots_[*j];
      const PolarForm& form = pivot_forms_[*j];
      const bool is_divisible = std::all_of(sums.begin(), sums.end(), [&](const VectorSum& sum) {
        return sum.count(pivot) == 0 || sum.at(pivot).divide(form.size);
      });
      const LengthPolynomial factor = is_divisible ? one() : form.size;
      denominator = denominator * factor;
      for (VectorSum& sum : sums) {
        sum = sum * factor;
        const auto found = sum.find(pivot);
        if (found == sum.end()) continue;
        const LengthPolynomial quotient = *found->second.divide(form.size) * (-std::conj(form.unit));
        sum.erase(found);
        for (const auto& [vector, link] : linkage_.closures[*j].links)
          if (vector != pivot) sum[vector] += link * quotient;
        sum[0] += linkage_.closures[*j].ground * quotient;
      }
    }
    return denominator;
  }

  /// The sums in the unknowns W: divided by the vectors' lengths, and multiplied by a common length.
  LengthPolynomial divide_by_scales(std::vector<VectorSum>& sums) const {
    LengthPolynomial factor = eliminate_pivots(sums), extra = one();
    for (const VectorSum& sum : sums)
      for (const auto& [vector, coefficient] : sum) {
        const LengthPolynomial& scale = form_scales_[static_cast<std::size_t>(vector)];
        if (!(coefficient * extra).divide(scale)) extra = extra * scale;
      }
    for (VectorSum& sum : sums)
      for (auto& [vector, coefficient] : sum)
        coefficient = *(coefficient * extra).divide(form_scales_[static_cast<std::size_t>(vector)]);
    return factor * extra;
  }

  /// Adds factor · Re Σ_uv ā_u b_v W_uv.
  void add_form(const VectorSum& a, const VectorSum& b, const LengthPolynomial& factor,
                std::vector<LengthPolynomial>& coefficients) const {
    const auto at = [](const VectorSum& sum, int vector) {
      const auto found = sum.find(vector);
      return found == sum.end() ? LengthPolynomial() : found->second;
    };
    for (const auto& [pair, unknowns] : form_) {
      const auto& [u, v] = pair;
      LengthPolynomial product = at(a, u).conjugate() * at(b, v);
      if (u != v) product += at(a, v) * at(b, u).conjugate();
      product = product * factor;
      if (unknowns[0] >= 0) coefficients[static_cast<std::size_t>(unknowns[0])] += product.real();
      if (unknowns[1] >= 0) coefficients[static_cast<std::size_t>(unknowns[1])] += (product * imaginary_unit).real();
    }
  }

  PlacedHeight scale_height(const ForceTerms& forces, const MomentTerms& moments) const {
    std::vector<VectorSum> sums;
    for (const MomentTerm& term : moments) {
      sums.push_back(term.a);
      sums.push_back(term.b);
    }
    const LengthPolynomial root = divide_by_scales(sums);
    PlacedHeight height;
    height.scale = root * root;
    LengthPolynomial extra = one();
    if (linkage_.balances_forces)
      for (const auto& [function, sum] : forces)
        for (const auto& [vector, coefficient] : sum)
          if (const auto k = static_cast<std::size_t>(vector);
              k > 0 && !(coefficient * height.scale * extra).divide(scales_[k]))
            extra = extra * scales_[k];
    height.scale = height.scale * extra;
    const auto of = [&](std::size_t function) -> std::vector<LengthPolynomial>& {
      height.coefficients[function].resize(static_cast<std::size_t>(unknowns_));
      return height.coefficients[function];
    };
    for (std::size_t i = 0; i < moments.size(); ++i)
      add_form(sums[2 * i], sums[2 * i + 1], moments[i].factor * extra, of(moments[i].function));
    if (linkage_.balances_forces)
      for (const auto& [function, sum] : forces)
        for (const auto& [vector, coefficient] : sum) {
          const auto k = static_cast<std::size_t>(vector);
          if (k == 0) continue;
          const LengthPolynomial quotient = *(coefficient * height.scale).divide(scales_[k]);
          for (const auto& [unknown, solution] : solutions_[k])
            of(function)[static_cast<std::size_t>(unknown)] += (solution * quotient).real();
        }
    return height;
  }

  LengthPolynomial constant(LengthPolynomial::Coefficient value) const {
    return LengthPolynomial::constant(linkage_.variables, value);
  }
  LengthPolynomial one() const { return constant(1); }

  VectorSum position(int body, const LengthPolynomial& place) const {
    const auto k = static_cast<std::size_t>(body);
    const VectorSum reference{{0, constant(-linkage_.moment_reference)}};
    return linkage_.tree_joints[k] + VectorSum{{linkage_.directions[k], place}} + reference;
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
    if (is_opposite(vector) || (linkage_.balances_moments && is_real(vector))) return false;
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

  /// Before closures are solved, which multiplies the pivots' ones.
  void choose_scales() {
    scales_.assign(vectors_, one());
    for (std::size_t k = 1; k < vectors_; ++k)
      if (linkage_.joint_places[k].size() == 1) {
        const auto form = positive_polar_form(linkage_.joint_places[k].front());
        if (form && !form->size.constant_value()) scales_[k] = form->size;
      }
    for (std::size_t j = 0; j < pivots_.size(); ++j)
      scales_[static_cast<std::size_t>(pivots_[j])] = pivot_forms_[j].size;
    form_scales_ = scales_;
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
  std::vector<std::size_t> order_;                         ///< in which the closures are solved
  std::vector<LengthPolynomial> scales_;                   ///< per vector: s_k
  std::vector<UnknownSum> solutions_;                      ///< per vector: its w
  std::vector<LengthPolynomial> form_scales_;              ///< per vector that is no pivot: s_k
  std::map<std::array<int, 2>, std::array<int, 2>> form_;  ///< per pair of vectors: the parts of W, −1: zero
};

}  // namespace

VirtualLinkageResult make_virtual_linkage(const PlanarLinkage& linkage, const LengthBox& box) {
  return VirtualLinkageBuilder(linkage, box).build();
}

}  // namespace balance::certificate
