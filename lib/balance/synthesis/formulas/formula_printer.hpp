#pragma once
/// Prints polynomials for people. Every text can be parsed again (formula_parser.hpp).
///
/// The rules, in this order: common factors are factored out (½ only if that is shorter); squares are recognised; with
/// waves (sines and cosines), terms are grouped by wave, or by inertia with powers of sines and cosines if that is
/// shorter; otherwise fractions are kept separate, and the shortest of the forms grouped by inertia, by length and by
/// Horner's rule is chosen.

#include "balance/synthesis/formulas/symbolic_polynomial.hpp"

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance::formulas {

enum class PrintStyle { text, latex };

/// `theta1` as \theta_{1}, `lg2` as l_{g2}, `tare2` as \mathrm{tare}_{2}, `C1_10` as C_{1,10}, `Mhat11` as \hat M_{11}.
std::string latex_name(const std::string& name);

class FormulaPrinter {
 public:
  /// @param collected symbols by whose powers sums are grouped, the first one outermost
  explicit FormulaPrinter(Ring& ring, PrintStyle style = PrintStyle::text, std::vector<int> collected = {})
      : ring_(&ring), style_(style), collected_(std::move(collected)) {}

  std::string print(const Polynomial& p);
  /// With the ring's values instead of all symbols except coordinates, rates and named expressions.
  std::string print_numbers(const Polynomial& p) const;
  /// numerator / denominator, with common factors cancelled as far as they are recognised.
  std::string print_ratio(const Polynomial& numerator, const Polynomial& denominator);
  /// numerator factor / denominator, without multiplying the factor out.
  std::string print_product(const Polynomial& numerator, const Polynomial& denominator, const Polynomial& factor);
  std::string symbol_text(int symbol) const;
  std::string angle_text(int angle) const;

 private:
  /// An expression ready to print, the number of symbols in it, and whether it needs brackets in a product.
  struct Printed {
    std::string text;
    int size = 0;
    bool is_sum = false;
    bool is_quotient = false;  ///< over / (divisor under), if it is text
    std::string over, under;
    std::int64_t divisor = 1;
  };
  /// A product with a minus in front is a sum.
  static void negate(Printed& printed) {
    printed.text.insert(0, "-");
    printed.is_sum = true, printed.is_quotient = false;
  }
  struct Ratio;
  using Part = std::function<Term(const Term&)>;  ///< monomial and wave by which a term is grouped

  // formula_printer.cpp
  Printed format(const Polynomial& p, int depth);
  Printed format_sum(const Polynomial& p, int depth);
  Printed format_without_trigonometric(const Polynomial& p, int depth);
  std::optional<Printed> factor_out_content(const Polynomial& p, int depth);
  Printed square_of(const Polynomial& root, int depth);
  std::optional<Printed> factor_out_number(const Polynomial& p, int depth);
  Printed format_grouped(const Polynomial& p, const Part& part, int depth);
  Printed group(const Term& key, const Polynomial& rest, int depth, bool& negative);
  bool is_minus_taken_out(const Polynomial& p) const;
  Ratio simplify(Polynomial numerator, Polynomial denominator) const;
  void remove_placeholders();

  // formula_printer.cpp
  std::string number(Rational value) const;
  std::string factor(int symbol, int exponent) const;
  std::string circular(const CircularFunction& function, int divisor = 1) const;
  std::string format_trigonometric(TrigonometricId trig) const;
  Printed term(const Monomial& monomial, Rational factor, TrigonometricId trig) const;
  Printed bracketed(Printed inner) const;
  Printed divided(const Printed& numerator, Printed denominator) const;
  Printed product(const Monomial& monomial, Rational coefficient, TrigonometricId trig, const Printed& inner) const;
  Printed quotient(std::string over, std::int64_t divisor, std::string under, int size) const;
  Printed join_terms(std::vector<std::pair<bool, Printed>> parts) const;
  std::vector<Term> sorted(const Polynomial& p) const;
  std::string format_square(const std::string& text) const;

  // formula_printer_squares.cpp
  std::optional<Polynomial> square_root(const Polynomial& p) const;
  std::optional<Polynomial> trigonometric_root(const Polynomial& p) const;
  std::optional<Printed> format_squares(const Polynomial& p);
  bool to_cosine_powers(const Polynomial& p, Polynomial& result);
  Polynomial placeholder(const std::string& text, int exponent);

  Ring* ring_;
  PrintStyle style_;
  std::vector<int> collected_;
  std::map<std::string, int> placeholders_;  ///< symbols that stand for text
  bool is_number_factored_out_ = false, recognises_squares_ = true;
};

}  // namespace balance::formulas
