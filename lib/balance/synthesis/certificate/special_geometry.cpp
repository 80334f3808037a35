#include "balance/synthesis/certificate/special_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace balance::certificate {
namespace {

/// Relative: sides that differ by less are equal.
constexpr double length_tolerance = 1e-12;
constexpr std::size_t max_parallelograms = 3;

/// A loop of four links, one of which may be the ground (body 0), as a combination of closures.
struct FourLinkLoop {
  std::vector<int> combination;             ///< per closure: −1, 0, 1
  std::array<std::array<int, 2>, 2> pairs;  ///< opposite links
  VectorSum sides;                          ///< with the ground's
};

LengthPolynomial squared(const LengthPolynomial& p) { return (p * p.conjugate()).real(); }

bool may_be_zero(const LengthPolynomial& p, const LengthBox& box) {
  const auto [low, high] = enclose_range(p, box);
  return low <= 0 && high >= 0;
}

bool may_be_equal(const LengthPolynomial& p, const LengthPolynomial& q, const LengthBox& box) {
  const LengthPolynomial difference = squared(p) - squared(q);
  const auto [low, high] = enclose_range(difference, box);
  const double margin = 4 * length_tolerance * std::abs(enclose_range(squared(p), box).second);
  return low <= margin && high >= -margin;
}

class GeometryFinder {
 public:
  GeometryFinder(const PlanarLinkage& linkage, const LengthBox& box) : linkage_(linkage), box_(box) {}

  SpecialGeometries find() {
    if (linkage_.closures.size() > max_combined_closures) {
      result_.uncovered.emplace_back("special geometries (there are too many loops)");
      return std::move(result_);
    }
    list_loops();
    if (loops_.size() > max_parallelograms) {
      result_.uncovered.emplace_back("parallelograms (there are too many loops of four links)");
      return std::move(result_);
    }
    for (unsigned set = 1; set < (1U << loops_.size()); ++set) add_geometry(set);
    if (linkage_.balances_moments) {
      for (const FourLinkLoop& loop : loops_) add_kites(loop);
      note_moment_geometries();
    }
    note_other_geometries();
    note_vanishing_links();
    return std::move(result_);
  }

 private:
  void note(std::string geometry) {
    if (std::find(result_.uncovered.begin(), result_.uncovered.end(), geometry) == result_.uncovered.end())
      result_.uncovered.push_back(std::move(geometry));
  }

  std::string loop_name(const FourLinkLoop& loop) const {
    std::string name;
    for (const auto& [vector, side] : loop.sides) {
      (void)side;
      name += (name.empty() ? "" : "–") + linkage_.vectors[static_cast<std::size_t>(vector)].name;
    }
    return name;
  }

  void list_loops() {
    const std::size_t count = linkage_.closures.size();
    std::size_t combinations = 1;
    for (std::size_t j = 0; j < count; ++j) combinations *= 3;
    for (std::size_t code = 1; code < combinations; ++code) {
      FourLinkLoop loop;
      std::size_t rest = code;
      int first = 0;
      for (std::size_t j = 0; j < count; ++j, rest /= 3) {
        loop.combination.push_back(static_cast<int>((rest % 3 + 1) % 3) - 1);  // 0, 1, 2 → 0, 1, −1
        if (first == 0) first = loop.combination.back();
      }
      if (first != 1) continue;
      add_loop(std::move(loop));
    }
  }

  void add_loop(FourLinkLoop loop) {
    LengthPolynomial ground;
    for (std::size_t j = 0; j < loop.combination.size(); ++j) {
      if (loop.combination[j] == 0) continue;
      const LengthPolynomial sign = LengthPolynomial::constant(linkage_.variables, loop.combination[j]);
      loop.sides = loop.sides + linkage_.closures[j].links * sign;
      ground += linkage_.closures[j].ground * sign;
    }
    if (!ground.is_zero()) loop.sides[0] = ground;
    for (auto side = loop.sides.begin(); side != loop.sides.end();)
      side = side->second.is_zero() ? loop.sides.erase(side) : std::next(side);
    const auto is_slide = [&](const auto& side) { return slides_along(side.first) >= 0; };
    if (loop.sides.size() != 4 || std::any_of(loop.sides.begin(), loop.sides.end(), is_slide)) return;
    if (!find_opposite_links(loop)) {
      note("special geometries of " + loop_name(loop));
      return;
    }
    loops_.push_back(std::move(loop));
  }

  int slides_along(int vector) const { return linkage_.vectors[static_cast<std::size_t>(vector)].slides_along; }

  bool are_joined(int a, int b) const {
    return std::any_of(linkage_.joints.begin(), linkage_.joints.end(), [&](const std::array<int, 2>& joint) {
      return (joint[0] == a && joint[1] == b) || (joint[0] == b && joint[1] == a);
    });
  }

  bool find_opposite_links(FourLinkLoop& loop) const {
    std::vector<int> links;
    for (const auto& [vector, side] : loop.sides) {
      (void)side;
      links.push_back(vector);
    }
    std::vector<std::array<int, 2>> apart;
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = a + 1; b < 4; ++b)
        if (!are_joined(links[a], links[b])) apart.push_back({links[a], links[b]});
    if (apart.size() != 2) return false;
    const std::set<int> all{apart[0][0], apart[0][1], apart[1][0], apart[1][1]};
    if (all.size() != 4) return false;
    loop.pairs = {apart[0], apart[1]};
    return true;
  }

  /// Makes two sides equal by replacing a length, or else by a condition.
  enum class Equality { impossible, made };
  Equality make_equal(LengthPolynomial p, LengthPolynomial q, SpecialGeometry& geometry) const {
    for (const auto& [number, value] : geometry.substitution) {
      p = p.substitute(number, value);
      q = q.substitute(number, value);
    }
    if (!may_be_equal(p, q, geometry.box)) return Equality::impossible;
    const auto a = find_polar_form(p), b = find_polar_form(q);
    if (!a || !b || !(enclose_range(a->size, geometry.box).first > 0) ||
        !(enclose_range(b->size, geometry.box).first > 0)) {
      geometry.equalities.push_back({squared(p) - squared(q), true});
      return Equality::made;
    }
    const LengthPolynomial difference = a->size - b->size;
    const auto constant = difference.constant_value();
    if (constant)  // may_be_equal: they are
      return Equality::made;
    for (int number = 0; number < linkage_.variables; ++number) {
      const std::optional<LengthPolynomial> value = solve_for(difference, number);
      if (value) return replace(number, *value, geometry);
    }
    geometry.equalities.push_back({difference, true});
    return Equality::made;
  }

  /// The variable as a polynomial of the others where p = 0, if it has a constant coefficient in p.
  std::optional<LengthPolynomial> solve_for(const LengthPolynomial& p, int number) const {
    const LengthPolynomial variable = LengthPolynomial::variable(linkage_.variables, number);
    const auto found = p.terms().find(variable.terms().begin()->first);
    if (found == p.terms().end()) return {};
    const LengthPolynomial rest = p - variable * found->second;
    if (rest.has_variable(number)) return {};
    return rest * (-1.0 / found->second);
  }

  Equality replace(int number, const LengthPolynomial& value, SpecialGeometry& geometry) const {
    const double margin =
        length_tolerance * std::max(std::abs(geometry.box.lower[number]), std::abs(geometry.box.upper[number]));
    const double lower = geometry.box.lower[number] - margin, upper = geometry.box.upper[number] + margin;
    const auto [low, high] = enclose_range(value, geometry.box);
    if (high < lower || low > upper) return Equality::impossible;
    contract(value, lower, upper, geometry.box);
    for (auto& [other, earlier] : geometry.substitution) earlier = earlier.substitute(number, value);
    for (LengthCondition& equality : geometry.equalities)
      equality.polynomial = equality.polynomial.substitute(number, value);
    geometry.substitution[number] = value;
    return Equality::made;
  }

  /// Where value = c₀ + c₁ u, lower ≤ value ≤ upper bounds u.
  static void contract(const LengthPolynomial& value, double lower, double upper, LengthBox& box) {
    int variable = -1;
    double slope = 0, offset = 0;
    for (const auto& [exponents, coefficient] : value.terms()) {
      int degree = 0, which = -1;
      for (std::size_t i = 0; i < exponents.size(); ++i) {
        degree += exponents[i];
        if (exponents[i] > 0) which = static_cast<int>(i);
      }
      if (degree > 1 || (degree == 1 && variable >= 0)) return;
      if (degree == 0) {
        offset = coefficient.real();
      } else {
        variable = which;
        slope = coefficient.real();
      }
    }
    if (variable < 0) return;
    const double first = (lower - offset) / slope, second = (upper - offset) / slope;
    const double margin = length_tolerance * (std::abs(first) + std::abs(second));
    box.lower[variable] = std::max(box.lower[variable], std::min(first, second) - margin);
    box.upper[variable] = std::min(box.upper[variable], std::max(first, second) + margin);
  }

  void add_geometry(unsigned set) {
    SpecialGeometry geometry;
    geometry.box = box_;
    geometry.closures = linkage_.closures;
    std::vector<bool> is_replaced(linkage_.closures.size(), false);
    std::vector<LoopClosure> parts;
    bool is_known = true;
    for (std::size_t l = 0; l < loops_.size(); ++l) {
      if (((set >> l) & 1U) == 0) continue;
      const FourLinkLoop& loop = loops_[l];
      geometry.name += (geometry.name.empty() ? "" : " and ") + loop_name(loop);
      for (const auto& pair : loop.pairs) {
        const Equality equality = make_equal(loop.sides.at(pair[0]), loop.sides.at(pair[1]), geometry);
        if (equality == Equality::impossible) return;
      }
      std::size_t replaced = 0;
      while (replaced < is_replaced.size() && (is_replaced[replaced] || loop.combination[replaced] == 0)) ++replaced;
      if (replaced == is_replaced.size()) {
        is_known = false;
        continue;
      }
      is_replaced[replaced] = true;
      for (const auto& pair : loop.pairs) parts.push_back(split(loop, pair));
    }
    geometry.name += " as a parallelogram";
    for (int i = 0; i < linkage_.variables; ++i)
      if (geometry.box.lower[i] > geometry.box.upper[i]) return;
    if (!is_known) {
      note(geometry.name);
      return;
    }
    std::vector<LoopClosure> closures = std::move(parts);
    for (std::size_t j = 0; j < is_replaced.size(); ++j)
      if (!is_replaced[j]) closures.push_back(linkage_.closures[j]);
    geometry.closures = std::move(closures);
    result_.geometries.push_back(std::move(geometry));
  }

  /// With the closures of general lengths, but other conditions of moments.
  void add_kites(const FourLinkLoop& loop) {
    const auto [a, c] = loop.pairs[0];
    const auto [b, d] = loop.pairs[1];
    for (const auto& pairs :
         {std::array{std::array{a, b}, std::array{c, d}}, std::array{std::array{b, c}, std::array{d, a}}}) {
      SpecialGeometry geometry;
      geometry.box = box_;
      geometry.closures = linkage_.closures;
      geometry.name = loop_name(loop) + " as a kite";
      const bool is_possible = std::all_of(pairs.begin(), pairs.end(), [&](const std::array<int, 2>& pair) {
        return make_equal(loop.sides.at(pair[0]), loop.sides.at(pair[1]), geometry) != Equality::impossible;
      });
      if (!is_possible || (geometry.box.lower.array() > geometry.box.upper.array()).any()) continue;
      if (linkage_.closures.size() > 1)
        note(std::move(geometry.name));  // together with other loops
      else
        result_.geometries.push_back(std::move(geometry));
    }
  }

  /// Where it is not shown that all lengths have the same conditions.
  void note_moment_geometries() {
    const bool has_slides = std::any_of(linkage_.vectors.begin(), linkage_.vectors.end(),
                                        [](const MovingVector& vector) { return vector.slides_along >= 0; });
    if (!has_slides || linkage_.loops == 0) return;
    if (linkage_.loops == 1 && linkage_.closures.size() == 1) {
      const VectorSum& links = linkage_.closures[0].links;
      const auto is_slide = [&](const auto& link) { return slides_along(link.first) >= 0; };
      const auto is_ground_slide = [&](const auto& link) { return slides_along(link.first) == 0; };
      const auto slides = std::count_if(links.begin(), links.end(), is_slide);
      if (slides == 1 && std::any_of(links.begin(), links.end(), is_ground_slide) &&
          (links.size() == 3 || links.size() == 4))
        return;  // as its forces
    }
    note("special geometries of moments");
  }

  static LoopClosure split(const FourLinkLoop& loop, const std::array<int, 2>& pair) {
    LoopClosure part;
    for (const int link : pair) {
      if (link == 0)
        part.ground = loop.sides.at(link);
      else
        part.links[link] = loop.sides.at(link);
    }
    return part;
  }

  void note_other_geometries() {
    const bool has_slides = std::any_of(linkage_.vectors.begin(), linkage_.vectors.end(),
                                        [](const MovingVector& vector) { return vector.slides_along >= 0; });
    if (linkage_.has_gears && linkage_.loops > 0) note("special geometries of loops with gears");
    if (linkage_.loops > 1 && !turns_one_link()) note("special geometries of several loops together");
    if (linkage_.loops == 1 && linkage_.closures.size() == 1) {
      const LoopClosure& closure = linkage_.closures[0];
      if (has_slides)
        note_slide_geometries(closure);
      else if (closure.links.size() > 4)
        note("special geometries of a loop of more than five links");
      const bool has_ground_slide = std::any_of(closure.links.begin(), closure.links.end(),
                                                [&](const auto& link) { return slides_along(link.first) == 0; });
      if (!has_ground_slide && may_be_zero(squared(closure.ground), box_)) note("joints of the ground that coincide");
    }
    for (const FourLinkLoop& loop : loops_) {
      const int a = loop.pairs[0][0], b = loop.pairs[1][0], c = loop.pairs[0][1], d = loop.pairs[1][1];
      for (const auto& [p, q, r, s] : {std::array<int, 4>{a, b, c, d}, std::array<int, 4>{b, c, d, a}})
        if (may_be_equal(loop.sides.at(p), loop.sides.at(q), box_) &&
            may_be_equal(loop.sides.at(r), loop.sides.at(s), box_))
          note(loop_name(loop) + " folded to a kite of which two links turn as one");
    }
  }

  /// A joint of two links that coincides with the next frees one of them. Beside its own slide a link has an offset only.
  void note_vanishing_links() {
    for (const LoopClosure& closure : linkage_.closures)
      for (const auto& [vector, coefficient] : closure.links) {
        const auto is_own_slide = [&, own = vector](const auto& link) { return slides_along(link.first) == own; };
        if (slides_along(vector) >= 0 || std::any_of(closure.links.begin(), closure.links.end(), is_own_slide))
          continue;
        const auto form = find_polar_form(coefficient);
        if (may_be_zero(form ? form->size : squared(coefficient), box_))
          note("joints of " + linkage_.vectors[static_cast<std::size_t>(vector)].name + " that coincide");
      }
  }

  /// All vectors are linear in the direction of one link, its conjugate, and 1, whatever the lengths are.
  bool turns_one_link() const {
    std::set<int> turning;
    for (const LoopClosure& closure : linkage_.closures)
      for (const auto& [vector, coefficient] : closure.links) {
        (void)coefficient;
        if (slides_along(vector) != 0) turning.insert(vector);
      }
    return turning.size() == 1 && slides_along(*turning.begin()) < 0;
  }

  /// Of the only loop.
  void note_slide_geometries(const LoopClosure& closure) {
    std::vector<int> links, ground_slides, other_slides;
    for (const auto& [vector, coefficient] : closure.links) {
      (void)coefficient;
      (slides_along(vector) < 0 ? links : slides_along(vector) == 0 ? ground_slides : other_slides).push_back(vector);
    }
    const auto across = [&](const LengthPolynomial& p, int slide) {
      const auto axis = find_polar_form(closure.links.at(slide));
      return axis ? (p * (-imaginary_unit * std::conj(axis->unit))).real() : LengthPolynomial();
    };
    const auto side = [&](int vector) {
      const auto found = closure.links.find(vector);
      return found == closure.links.end() ? LengthPolynomial() : found->second;
    };
    const auto name = [&](int vector) { return linkage_.vectors[static_cast<std::size_t>(vector)].name; };
    if (ground_slides.size() == 1 && other_slides.empty()) {
      const bool is_crank = links.size() == 2;
      if (!is_crank && links.size() != 3) return note("special geometries of its loop");
      if (is_crank && may_be_equal(side(links[0]), side(links[1]), box_) &&
          may_be_zero(across(closure.ground, ground_slides[0]), box_))
        note(name(links[0]) + " and " + name(links[1]) + " of one length, in line with " + name(ground_slides[0]));
      return;
    }
    if (ground_slides.size() == 2 && other_slides.empty()) {
      // both slides follow from any directions of the links
      if (may_be_zero(across(side(ground_slides[1]), ground_slides[0]), box_))
        note(name(ground_slides[0]) + " and " + name(ground_slides[1]) + " parallel");
      return;
    }
    if (other_slides.size() == 1) {
      const int slide = other_slides[0], lever = slides_along(slide);
      std::vector<int> turning = links;
      if (std::find(turning.begin(), turning.end(), lever) == turning.end()) turning.push_back(lever);
      if (ground_slides.empty() && turning.size() == 2) {
        const int crank = turning[0] == lever ? turning[1] : turning[0];
        if (may_be_equal(side(crank), closure.ground, box_) && may_be_zero(across(side(lever), slide), box_))
          note("the slide " + name(slide) + " through the bearing of " + name(lever));
        return;
      }
      if (ground_slides.empty() && turning.size() == 3) return;
      if (ground_slides.size() == 1 && turning.size() == 1) {
        if (may_be_zero(across(closure.ground, ground_slides[0]), box_) &&
            may_be_zero(across(side(lever), slide), box_))
          note("the slide " + name(slide) + " through the bearing of " + name(lever));
        return;
      }
    }
    note("special geometries of its loop");
  }

  const PlanarLinkage& linkage_;
  const LengthBox& box_;
  std::vector<FourLinkLoop> loops_;
  SpecialGeometries result_;
};

}  // namespace

SpecialGeometries find_special_geometries(const PlanarLinkage& linkage, const LengthBox& box) {
  return GeometryFinder(linkage, box).find();
}

}  // namespace balance::certificate
