#include "balance/report/base64.hpp"

#include <bit>
#include <cstdint>
#include <cstring>

namespace balance {
namespace {

static_assert(std::endian::native == std::endian::little, "the page's samples are little-endian");

template <class Number>
void append(std::string& bytes, Number number) {
  char raw[sizeof number];
  std::memcpy(raw, &number, sizeof number);
  bytes.append(raw, sizeof number);
}

}  // namespace

std::string base64(std::string_view bytes) {
  static constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? digits[group >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

std::string base64_floats(const Samples& by_row) {
  std::string bytes;
  bytes.reserve(static_cast<std::size_t>(by_row.size()) * sizeof(float));
  for (Eigen::Index i = 0; i < by_row.rows(); ++i)
    for (Eigen::Index j = 0; j < by_row.cols(); ++j) append(bytes, static_cast<float>(by_row(i, j)));
  return base64(bytes);
}

std::string base64_float_columns(const Samples& samples) { return base64_floats(Samples(samples.transpose())); }

std::string base64_doubles(const VectorX& numbers) {
  std::string bytes;
  for (const double number : numbers) append(bytes, number);
  return base64(bytes);
}

}  // namespace balance
