#include "balance/motion/study/study.hpp"

#include <algorithm>

namespace balance {

void reject_temporary_payloads(const Study& study, const std::string& what, const std::vector<std::string>* without) {
  const auto left_out = [&](const std::string& name) {
    return without != nullptr && std::find(without->begin(), without->end(), name) != without->end();
  };
  if (left_out("payloads")) return;
  for (const TemporaryPayload& payload : study.temporary_payloads) {
    if (left_out(payload.name)) continue;
    const std::string expected = "payloads that are always there, for " + what;
    const std::string found = "'" + payload.name + "', which is taken up or set down on the way";
    const std::string hint = without == nullptr ? "" : "--without " + payload.name + " leaves it out";
    throw SpecError({.place = payload.place,
                     .message = "expected " + expected + ", found " + found + (hint.empty() ? "" : "; " + hint),
                     .expected = expected,
                     .found = found,
                     .hint = hint});
  }
}

}  // namespace balance
