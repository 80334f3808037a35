#include "balance/foundation/base/elementary.hpp"

#include <bit>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <limits>

// 113-bit numbers: `long double` if it has that precision, else __float128 with glibc's functions, which GCC and clang
// compute in software.
#if LDBL_MANT_DIG == 113
#define BALANCE_WIDE(name) name##l
namespace balance {
using Binary128 = long double;
}
#elif defined(__SIZEOF_FLOAT128__) && defined(__GLIBC__)
#define BALANCE_WIDE(name) name##f128
namespace balance {
__extension__ typedef __float128 Binary128;
}
#define BALANCE_DECLARE(name) balance::Binary128 name##f128(balance::Binary128) noexcept
extern "C" {  // <cmath> declares them for GCC only
BALANCE_DECLARE(sinh);
BALANCE_DECLARE(cosh);
BALANCE_DECLARE(tanh);
BALANCE_DECLARE(asinh);
BALANCE_DECLARE(acosh);
BALANCE_DECLARE(atanh);
BALANCE_DECLARE(exp);
BALANCE_DECLARE(log);
BALANCE_DECLARE(log10);
BALANCE_DECLARE(log2);
BALANCE_DECLARE(log1p);
balance::Binary128 powf128(balance::Binary128, balance::Binary128) noexcept;
}
#undef BALANCE_DECLARE
#else  // on other machines the last digits differ
#define BALANCE_WIDE(name) name
namespace balance {
using Binary128 = double;
}
#endif

namespace balance::elementary {

namespace {

constexpr double pi_high = 3.14159265358979311600e+00, pi_low = 1.2246467991473531772e-16;

/// q − atan q for |q| ≤ 7/16: the polynomial of fdlibm (s_atan.c).
double atan_reduction(double q) {
  const double z = q * q, w = z * z;
  const double odd = z * (3.33333333333329318027e-01 +
                          w * (1.42857142725034663711e-01 +
                               w * (9.09088713343650656196e-02 +
                                    w * (6.66107313738753120669e-02 +
                                         w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)))));
  const double even =
      w *
      (-1.99999999998764832476e-01 +
       w * (-1.11111104054623557880e-01 +
            w * (-7.69187620504482999495e-02 + w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02))));
  return q * (odd + even);
}

/// atan(a/b) for 0 ≤ a ≤ b. Differences of nearby numbers are exact.
double atan_in_octant(double a, double b) {
  if (16 * a < 7 * b) {
    const double q = a / b;
    return q - atan_reduction(q);
  }
  const bool middle = 16 * a < 11 * b;  // expands about atan(1/2), else about π/4
  const double q = middle ? ((a + a) - b) / ((b + b) + a) : (a - b) / (a + b);
  const double high = middle ? 4.63647609000806093515e-01 : pi_high / 4;
  const double low = middle ? 2.26987774529616870924e-17 : pi_low / 4;
  return high - ((atan_reduction(q) - low) - q);
}

}  // namespace

double atan2(double y, double x) {
  double a = std::fabs(y), b = std::fabs(x);
  const double largest = std::fmax(a, b);
  if (!(largest > 0 && largest < INFINITY) || std::isnan(y + x)) return std::atan2(y, x);  // multiples of π/4, or NaN
  if (largest > 0x1p1000) a *= 0x1p-100, b *= 0x1p-100;
  if (largest < 0x1p-900) a *= 0x1p150, b *= 0x1p150;
  const bool has_negative_x = std::signbit(x);
  double angle = atan_in_octant(std::fmin(a, b), std::fmax(a, b));
  if (a > b)
    angle = has_negative_x ? pi_high / 2 + (angle + pi_low / 2) : pi_high / 2 - (angle - pi_low / 2);
  else if (has_negative_x)
    angle = pi_high - (angle - pi_low);
  return std::copysign(angle, y);
}

double atan(double x) { return atan2(x, 1); }
double asin(double x) { return atan2(x, std::sqrt((1 - x) * (1 + x))); }
double acos(double x) { return atan2(std::sqrt((1 - x) * (1 + x)), x); }
double tan(double x) {
  const auto sc = sine_cosine(x);
  return sc.sine / sc.cosine;
}

#define BALANCE_ROUNDED(name) \
  double name(double x) { return static_cast<double>(BALANCE_WIDE(name)(x)); }
BALANCE_ROUNDED(sinh)
BALANCE_ROUNDED(cosh)
BALANCE_ROUNDED(tanh)
BALANCE_ROUNDED(asinh)
BALANCE_ROUNDED(acosh)
BALANCE_ROUNDED(atanh)
BALANCE_ROUNDED(exp)
BALANCE_ROUNDED(log)
BALANCE_ROUNDED(log10)
BALANCE_ROUNDED(log2)
BALANCE_ROUNDED(log1p)
#undef BALANCE_ROUNDED

double pow(double x, double y) {
  constexpr int max_integer_exponent = 16;  // beyond it the general case is as fast
  if (y == 2) return x * x;
  if (std::fabs(y) <= max_integer_exponent && y == std::nearbyint(y)) {
    Binary128 product = 1;
    for (int k = static_cast<int>(std::fabs(y)); k > 0; --k) product *= x;
    return static_cast<double>(y < 0 ? 1 / product : product);
  }
  return static_cast<double>(BALANCE_WIDE(pow)(x, y));
}
#undef BALANCE_WIDE

}  // namespace balance::elementary

namespace balance::sines {

namespace {

/// A word of zeros, then the binary fraction digits of 2/π.
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

/// 64 binary digits of 2/π, starting with the one of weight 2^−first.
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
  // |x| · 2/π = mantissa · 2^(exponent − 53) · 0.d₁d₂…: digits before `first` contribute multiples of four.
  const int first = exponent - 53 - 1;
  UInt128 sum = static_cast<UInt128>(mantissa) * two_over_pi_bits(first + 128) >> 64;
  const std::uint64_t low =
      static_cast<std::uint64_t>(sum += static_cast<UInt128>(mantissa) * two_over_pi_bits(first + 64));
  const std::uint64_t high = static_cast<std::uint64_t>(sum >> 64) + mantissa * two_over_pi_bits(first);
  // The product is (high, low) with `high` in units of 2^−62: two bits of quadrant, then the fraction of a quadrant.
  UInt128 fraction = (static_cast<UInt128>(high) << 64 | low) << 2;
  auto quadrant = static_cast<long long>(high >> 62);
  const bool rounds_up = (fraction >> 127) != 0;  // nearer to the next quadrant
  if (rounds_up) fraction = -fraction, ++quadrant;
  const int zeros = std::countl_zero(static_cast<std::uint64_t>(fraction >> 64));
  const auto leading = static_cast<std::uint64_t>(fraction << zeros >> 64);
  const auto radians = static_cast<std::uint64_t>(static_cast<UInt128>(leading) * 0xc90fdaa22168c235 >> 64);
  const double scale = std::ldexp((x < 0) != rounds_up ? -1 : 1, -63 - zeros);
  const std::uint64_t low_bits = radians & 0x7ff;
  return {scale * static_cast<double>(radians - low_bits), scale * static_cast<double>(low_bits),
          x < 0 ? -quadrant : quadrant};
}

}  // namespace balance::sines
