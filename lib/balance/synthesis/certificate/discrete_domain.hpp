#pragma once
/// Sizes and optional elements in the tree of lengths: what a part of all designs may contain, and how it is divided.
///
/// A mass with sizes may have any value between the first and the last of them in a part, and an element that may still
/// be left out is there: both only weaken a bound. A length with sizes has those within the part's box.

#include "balance/synthesis/certificate/length_geometry.hpp"

#include <vector>

namespace balance::certificate {

/// Elements of which a design keeps a limited number.
struct ElementChoice {
  struct Element {
    std::vector<int> numbers;      ///< free numbers that are zero if it is left out
    std::vector<int> own_numbers;  ///< others that have no effect then
  };
  std::vector<Element> elements;
  int max_count = -1;  ///< −1: as few as possible, over all such choices together
};

/// Number of elements that x keeps of the choices that ask for as few as possible.
int count_min_elements(const std::vector<ElementChoice>& choices, const VectorX& x);

/// A part of all designs.
struct DesignPart {
  enum class ElementState { undecided, kept, left_out };
  LengthBox box;                       ///< of all free numbers; only lengths matter
  std::vector<MassLimits> masses;      ///< per counterweight
  std::vector<ElementState> elements;  ///< of all choices together
};

/// The sizes and choices of one geometry.
class DiscreteDomain {
 public:
  /// @param space, geometry must outlive this object
  /// @param lengths on which its bound depends
  /// @param min_count limit of the choices that ask for as few elements as possible
  DiscreteDomain(const DesignSpace& space, const LengthGeometry& geometry, std::vector<int> lengths,
                 const std::vector<ElementChoice>& choices, int min_count);

  /// All designs of the geometry.
  DesignPart root() const;
  /// Applies all consequences of the decisions so far. @return false if the part is empty
  bool propagate(DesignPart& part) const;
  /// The largest sum of the masses of counterweights [kg].
  double max_mass(const DesignPart& part) const;

  bool has_sizes(int length) const { return !sizes_[static_cast<std::size_t>(length)].empty(); }
  /// The two halves of a part along a length.
  std::vector<DesignPart> divide_length(const DesignPart& part, int length) const;
  /// With an element left out and kept, if the relaxation keeps too many; the one to try first is last.
  /// @param masses of the relaxation, per counterweight
  std::vector<DesignPart> divide_elements(const DesignPart& part, const VectorX& masses) const;
  /// Below and above a mass that is farthest from its sizes; empty if all masses have sizes.
  /// @param distance from the next size [kg]
  std::vector<DesignPart> divide_masses(const DesignPart& part, const VectorX& masses, double& distance) const;

  /// The nearest sizes within the part.
  VectorX round_lengths(const DesignPart& part, VectorX lengths) const;
  /// A length after a step: at least one size further, if it has sizes.
  double step_length(int length, double from, double step) const;
  /// Round-off is removed from numbers at bounds and sizes, and elements that are left out get their start values.
  /// @return false if x is no design: outside bounds or sizes, with too many elements, or with equal sizes that must
  /// differ
  bool complete(VectorX& x) const;

 private:
  struct Element {
    std::vector<int> counterweights, lengths;  ///< that vanish with it
    std::vector<int> numbers, own_numbers;
    std::size_t group = 0;

    bool has_effect() const { return !counterweights.empty() || !lengths.empty(); }
  };
  bool propagate_sizes(DesignPart& part) const;
  bool propagate_element(DesignPart& part, std::size_t k) const;
  bool propagate_counts(DesignPart& part) const;
  bool has_different_sizes(const VectorX& x, const std::vector<bool>& is_present) const;
  /// Of a number; for lengths that others replace, common sizes.
  void restrict_sizes();

  const DesignSpace& space_;
  const LengthGeometry& geometry_;
  std::vector<int> lengths_;
  std::vector<Element> elements_;
  std::vector<int> groups_;                 ///< maximum number of kept elements
  std::vector<std::vector<double>> sizes_;  ///< per free number, ascending; empty: any
  bool is_empty_ = false;                   ///< lengths that must be equal have no common size
};

}  // namespace balance::certificate
