#include "balance/formulas/monomial.hpp"

namespace balance::formulas {

int Monomial::exponent_of(int symbol) const {
  for (int k = 0; k < size_; ++k)
    if (this->symbol(k) == symbol) return exponent(k);
  return 0;
}

void Monomial::append(int symbol, int exponent) {
  if (exponent == 0) return;
  if (exponent < -15 || exponent > 15) throw FormulaError("a power is too high");
  if (size_ == max_factors) throw FormulaError("a product has too many factors");
  factors_[size_++] = static_cast<std::uint16_t>((symbol << 5) | (exponent + 16));
}

Monomial Monomial::inverse() const {
  Monomial below;
  for (int k = 0; k < size_; ++k) below.append(symbol(k), -exponent(k));
  return below;
}

Monomial operator*(const Monomial& a, const Monomial& b) {
  if (a.size_ == 0) return b;
  if (b.size_ == 0) return a;
  Monomial product;
  int i = 0, j = 0;
  while (i < a.size_ || j < b.size_) {
    const bool left = j == b.size_ || (i < a.size_ && a.symbol(i) <= b.symbol(j));
    const bool right = i == a.size_ || (j < b.size_ && b.symbol(j) <= a.symbol(i));
    product.append(left ? a.symbol(i) : b.symbol(j), (left ? a.exponent(i) : 0) + (right ? b.exponent(j) : 0));
    i += left ? 1 : 0;
    j += right ? 1 : 0;
  }
  return product;
}

}  // namespace balance::formulas
