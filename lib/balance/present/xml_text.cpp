#include "balance/present/xml_text.hpp"

#include "balance/base/plain_text.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace balance {
namespace {

/// A character of XML 1.0, section 2.2.
bool is_allowed(std::uint32_t code) {
  return code == '\t' || code == '\n' || code == '\r' || (code >= 0x20 && code <= 0xD7FF) ||
         (code >= 0xE000 && code <= 0xFFFD) || (code >= 0x10000 && code <= 0x10FFFF);
}

}  // namespace

std::string escape_xml(std::string_view text) {
  std::string xml;
  while (!text.empty()) {
    const Utf8CodePoint one = decode_utf8(text);
    const std::size_t bytes = std::max<std::size_t>(one.bytes, 1);
    if (one.bytes == 0 || !is_allowed(one.code)) {
      xml += "\xEF\xBF\xBD";
    } else {
      switch (one.code) {
        case '&': xml += "&amp;"; break;
        case '<': xml += "&lt;"; break;
        case '>': xml += "&gt;"; break;
        case '"': xml += "&quot;"; break;
        // Written as they are, readers would make spaces of them in attributes.
        case '\t': xml += "&#9;"; break;
        case '\n': xml += "&#10;"; break;
        case '\r': xml += "&#13;"; break;
        default: xml += text.substr(0, bytes);
      }
    }
    text.remove_prefix(bytes);
  }
  return xml;
}

}  // namespace balance
