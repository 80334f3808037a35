#include "balance/base/sine.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace balance::sines {

namespace {

/// The binary digits of 2/π behind the point, after a word of zeros.
constexpr std::uint64_t two_over_pi[] = {0,
                                         0xa2f9836e4e441529,
                                         0xfc2757d1f534ddc0,
                                         0xdb6295993c439041,
                                         0xfe5163abdebbc561,
                                         0xb7246e3a424dd2e0,
                                         0x06492eea09d1921c,
                                         0xfe1deb1cb129a73e,
                                         0xe88235f52ebb4484,
                                         0xe99c7026b45f7e41,
                                         0x3991d639835339f4,
                                         0x9c845f8bbdf9283b,
                                         0x1ff897ffde05980f,
                                         0xef2f118b5a0a6d1f,
                                         0x6d367ecf27cb09b7,
                                         0x4f463f669e5fea2d,
                                         0x7527bac7ebe5f17b,
                                         0x3d0739f78a5292ea,
                                         0x6bfb5fb11f8d5d08,
                                         0x56033046fc7b6bab,
                                         0xf0cfbc209af4361d};

/// 64 digits from the one that stands for 2^−first on.
std::uint64_t two_over_pi_bits(int first) {
  const int bit = first + 63;
  const std::uint64_t *word = two_over_pi + bit / 64, shift = bit % 64;
  return shift ? word[0] << shift | word[1] >> (64 - shift) : word[0];
}

}  // namespace

ReducedArgument<double, long long> reduce_payne_hanek(double x) {
  if (!std::isfinite(x)) return {std::numeric_limits<double>::quiet_NaN(), 0, 0};
  __extension__ using UInt128 = unsigned __int128;
  int exponent;
  const auto mantissa = static_cast<std::uint64_t>(std::ldexp(std::frexp(std::abs(x), &exponent), 53));
  // |x| · 2/π = mantissa · 2^(exponent − 53) · 0.d₁d₂…: digits in front of these add multiples of four.
  const int first = exponent - 53 - 1;
  UInt128 sum = static_cast<UInt128>(mantissa) * two_over_pi_bits(first + 128) >> 64;
  const std::uint64_t low =
      static_cast<std::uint64_t>(sum += static_cast<UInt128>(mantissa) * two_over_pi_bits(first + 64));
  const std::uint64_t high = static_cast<std::uint64_t>(sum >> 64) + mantissa * two_over_pi_bits(first);
  // The product is high, low in units of 2^−62 of `high`: two bits of quadrant, then the fraction of a quadrant.
  UInt128 fraction = (static_cast<UInt128>(high) << 64 | low) << 2;
  auto quadrant = static_cast<long long>(high >> 62);
  const bool above = (fraction >> 127) != 0;  // nearer to the next quadrant
  if (above) fraction = -fraction, ++quadrant;
  const int zeros = std::countl_zero(static_cast<std::uint64_t>(fraction >> 64));
  const auto leading = static_cast<std::uint64_t>(fraction << zeros >> 64);
  const auto turned = static_cast<std::uint64_t>(static_cast<UInt128>(leading) * 0xc90fdaa22168c235 >> 64);
  const double scale = std::ldexp((x < 0) != above ? -1 : 1, -63 - zeros);
  const std::uint64_t last = turned & 0x7ff;
  return {scale * static_cast<double>(turned - last), scale * static_cast<double>(last), x < 0 ? -quadrant : quadrant};
}

}  // namespace balance::sines
