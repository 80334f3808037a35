#include "balance/interface/files/json.hpp"

#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/files/result_group.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace balance::files {
namespace {

/// Invisible characters occur only in strings, where they may be written as escapes.
std::string escape_invisible_json(std::string_view json) {
  std::string text;
  text.reserve(json.size());
  const auto is_plain = [](char c) { return static_cast<unsigned char>(c) < 0x7f; };
  for (;;) {
    const auto plain_length =
        static_cast<std::size_t>(std::find_if_not(json.begin(), json.end(), is_plain) - json.begin());
    text += json.substr(0, plain_length);
    json.remove_prefix(plain_length);
    if (json.empty()) break;
    const Utf8CodePoint code_point = decode_utf8(json);
    const std::size_t bytes = std::max<std::size_t>(code_point.bytes, 1);
    if (!is_invisible(code_point.code))
      text += json.substr(0, bytes);
    else if (code_point.code < 0x10000)
      text += fmt::format("\\u{:04x}", code_point.code);
    else
      text += fmt::format("\\u{:04x}\\u{:04x}", 0xD7C0 + (code_point.code >> 10), 0xDC00 + (code_point.code & 0x3FF));
    json.remove_prefix(bytes);
  }
  return text;
}

}  // namespace

std::string format_json(const Json& value) {
  // Names that are not UTF-8 must not prevent the output.
  return escape_invisible_json(value.dump(2, ' ', false, Json::error_handler_t::replace)) + "\n";
}

Json named_numbers_json(const std::vector<std::string>& names, const VectorX& values) {
  Json json = Json::object();
  const std::size_t count = std::min(names.size(), static_cast<std::size_t>(values.size()));
  for (std::size_t k = 0; k < count; ++k) json[names[k]] = values[static_cast<Eigen::Index>(k)];
  return json;
}

Json vector_json(const Vector3& vector, int axes) { return std::vector<double>(vector.data(), vector.data() + axes); }

Json numbers_json(const VectorX& numbers) { return std::vector<double>(numbers.begin(), numbers.end()); }

Json metrics_json(const std::vector<Metric>& metrics) { return rows_json(metrics, metric_fields()); }

Json outcome_json(const MotionOutcome& outcome) {
  Json json = {{"status", name_of(outcome.status)}};
  if (outcome.status == MotionStatus::done) return json;
  json["time"] = outcome.time;
  json["reason"] = outcome.reason;
  return json;
}

}  // namespace balance::files
