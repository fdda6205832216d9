#include "ingest/dicom/data_set.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

namespace diaphane::dicom {
namespace {

std::string_view without_padding(std::string_view text) {
  const auto is_padding = [](char c) { return c == ' ' || c == '\0'; };
  while (!text.empty() && is_padding(text.back())) text.remove_suffix(1);
  while (!text.empty() && is_padding(text.front())) text.remove_prefix(1);
  return text;
}

std::string_view chars_of(const DataSet& set, std::uint32_t tag) {
  const DataElement* element = find(set, tag);
  if (element == nullptr) return {};
  return {reinterpret_cast<const char*>(element->value.data()), element->value.size()};
}

}  // namespace

const DataElement* find(const DataSet& set, std::uint32_t tag) {
  const auto found = std::find_if(set.begin(), set.end(),
                                  [tag](const DataElement& one) { return one.tag == tag; });
  return found == set.end() ? nullptr : &*found;
}

std::span<const DataSet> items_of(const DataSet& set, std::uint32_t tag) {
  const DataElement* element = find(set, tag);
  return element == nullptr ? std::span<const DataSet>() : std::span(element->items);
}

const DataSet* first_item(const DataSet& set, std::uint32_t tag) {
  const auto items = items_of(set, tag);
  return items.empty() ? nullptr : &items.front();
}

std::string text_of(const DataSet& set, std::uint32_t tag) {
  return std::string(without_padding(chars_of(set, tag)));
}

std::vector<double> decimals_of(const DataSet& set, std::uint32_t tag, std::size_t most) {
  std::vector<double> numbers;
  std::string_view rest = chars_of(set, tag);
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('\\'), rest.size());
    std::string_view one = without_padding(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (one.starts_with('+')) one.remove_prefix(1);
    double number = 0;
    const auto [stop, error] = std::from_chars(one.data(), one.data() + one.size(), number);
    if (error != std::errc() || stop != one.data() + one.size() || !std::isfinite(number)) {
      return {};
    }
    numbers.push_back(number);
    if (numbers.size() > most) break;
  }
  return numbers;
}

std::vector<std::uint16_t> shorts_of(const DataSet& set, std::uint32_t tag) {
  const std::string_view bytes = chars_of(set, tag);
  std::vector<std::uint16_t> numbers;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    const unsigned low = static_cast<std::uint8_t>(bytes[i]),
                   high = static_cast<std::uint8_t>(bytes[i + 1]);
    numbers.push_back(static_cast<std::uint16_t>(high << 8 | low));
  }
  return numbers;
}

std::optional<std::uint16_t> short_of(const DataSet& set, std::uint32_t tag) {
  const auto numbers = shorts_of(set, tag);
  return numbers.size() == 1 ? std::optional(numbers.front()) : std::nullopt;
}

std::optional<std::uint32_t> integer_of(const DataSet& set, std::uint32_t tag) {
  std::string_view text = without_padding(chars_of(set, tag));
  if (text.starts_with('+')) text.remove_prefix(1);
  std::uint32_t number = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || error != std::errc() || stop != text.data() + text.size()) {
    return std::nullopt;
  }
  return number;
}

}  // namespace diaphane::dicom
