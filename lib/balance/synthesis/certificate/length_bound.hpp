#pragma once
/// The least added (or total) mass over all lengths: a lower bound that holds for every choice of the free numbers
/// within their bounds, and the best design found on the way.
///
/// Branch and bound over boxes of lengths. A box's bound comes from one linear program (box_program.hpp), so that most
/// problems close at the root. Sizes and elements that may be left out are decided in the same tree.

#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/certificate/discrete_domain.hpp"
#include "balance/synthesis/certificate/length_proof.hpp"

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace balance::certificate {

/// Decides whether values of the free numbers are a design: whether they can be assembled, move as required and are
/// balanced.
class LengthDesignJudge {
 public:
  virtual ~LengthDesignJudge() = default;
  /// @param x all free numbers, in the study's order, within their bounds
  virtual bool accepts(const VectorX& x) const = 0;
};

/// A judge that derives the conditions anew at each design, and runs trajectories.
/// @param trajectories indices of those that every design must follow
std::unique_ptr<LengthDesignJudge> make_length_design_judge(const DesignSpace& space, std::vector<int> trajectories);

struct LengthBoundOptions {
  long max_nodes = 20'000;      ///< boxes bounded, at least 1
  double gap_tolerance = 1e-9;  ///< relative; the search ends below it
  /// Indices of trajectories that every design must follow; lengths with which they cannot be assembled do not count.
  std::vector<int> required_trajectories = {};
  /// Of the spec's elements; must not be empty if the spec has choices.
  std::vector<ElementChoice> choices = {};
  bool keeps_certificates = false;
};

/// What was known after a time.
struct LengthBoundProgress {
  double seconds = 0;      ///< of this search [s], CPU time
  double lower_bound = 0;  ///< [kg]
  double best = 0;         ///< [kg]; infinite: no design yet
};

/// The proof for one box of lengths.
struct LengthCertificate {
  int geometry = 0;  ///< into LengthBound::geometries
  LengthBox box;
  double bound = 0;  ///< no design with these lengths is lighter [kg]
  BoxCertificate multipliers;
};

struct LengthBound {
  std::string reason;       ///< empty: there is a bound; else completes "no certificate because …"
  std::string unit = "kg";  ///< of bound and best; empty: a sum of several
  double lower_bound = 0;   ///< no answer is lighter [kg], whatever the least number is; infinite: there is none at all
  double best = std::numeric_limits<double>::infinity();  ///< value of `design`
  VectorX design;                                         ///< all free numbers; empty: none found
  /// If as few elements as possible are asked for: the number for which bound and design are, and whether it is proved
  /// that fewer do not suffice; −1: not asked for.
  int count = -1;
  bool is_count_proved = false;
  std::vector<std::string> geometries;  ///< to which the bound applies
  std::vector<std::string> uncovered;   ///< geometries within the bounds to which it does not apply
  /// Names of the trajectories that restrict the lengths: it applies where they can be followed.
  std::vector<std::string> trajectories;
  std::vector<std::string> remarks;           ///< further sentences about what it covers
  long nodes = 0;                             ///< boxes bounded
  std::vector<LengthBoundProgress> progress;  ///< where bound or best design changed, and at the end
  /// If asked for, of boxes that cover all lengths that meet the geometries' conditions.
  std::vector<LengthCertificate> certificates;
  /// If asked for, of the bound, per geometry. Empty with sizes or choices.
  std::vector<GeometryProof> proof;

  bool is_impossible() const { return reason.empty() && std::isinf(lower_bound); }
  /// (best − lower_bound) / best; infinite without a design.
  double gap() const { return std::isinf(best) ? best : best <= lower_bound ? 0 : (best - lower_bound) / best; }
};

/// Indices of the trajectories that the start values can follow and that do not depend on masses.
std::vector<int> list_followed_trajectories(const DesignSpace& space);

/// A branch and bound that can be continued, and that hears of designs that others found.
class LengthBoundSearch {
 public:
  /// @param space, judge must outlive this object
  LengthBoundSearch(const DesignSpace& space, const LengthDesignJudge& judge, const LengthBoundOptions& options);
  ~LengthBoundSearch();

  /// Bounds boxes until the gap is closed, nothing is left to divide, the boxes or the time are used up.
  /// @param interrupted asked after every box
  void run(const std::function<bool()>& interrupted);
  /// A design of another search: x in the study's order, with sizes and numbers of elements that are allowed; its mass
  /// [kg].
  void add_design(const VectorX& x, double mass);
  /// Whether more time cannot tell more.
  bool is_finished() const;
  bool has_design() const;
  LengthBound result() const;

 private:
  class Trees;
  std::unique_ptr<Trees> trees_;
};

LengthBound bound_over_lengths(const DesignSpace& space, const LengthDesignJudge& judge,
                               const LengthBoundOptions& options = {});

}  // namespace balance::certificate
