#include "protocol/formats/html.h"

#include <algorithm>
#include <array>
#include <initializer_list>

#include "protocol/formats/decimal.h"

namespace engram {
namespace {

constexpr const char* kStyle = R"css(
body { font: 15px/1.45 system-ui, sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em;
       color: #222; background: #fff }
h1 { font-size: 1.5em } h2 { font-size: 1.15em; margin-top: 2em }
table { border-collapse: collapse; font-size: 13px }
th, td { padding: 2px 10px; border-bottom: 1px solid #ddd; text-align: left }
td.number { text-align: right; font-variant-numeric: tabular-nums }
figure { margin: 0 0 1em } figcaption { font-size: 13px; color: #555 }
img { max-width: 100%; image-rendering: pixelated } svg { max-width: 100%; height: auto }
)css";

constexpr std::array<const char*, 6> kColors = {"#4878a8", "#c8803c", "#5c9c5c",
                                                "#a05c98", "#98864c", "#8c8c8c"};

void append(std::string& text, std::initializer_list<std::string_view> pieces) {
  for (const std::string_view piece : pieces) text += piece;
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group =
          group << 8 | (i + k < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
    }
  }
  return out;
}

bool looks_like_number(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789.,-+%") == std::string_view::npos;
}

// --- bars: pixels ---

constexpr int kRow = 18;
constexpr int kLabels = 300;
constexpr int kLength = 400;

void append_scale(std::string& body, int height) {
  for (int tick = 0; tick <= 4; ++tick) {
    const std::string x = decimal(kLabels + kLength * tick / 4.0, 0);
    append(body,
           {"<line x1=\"", x, "\" y1=\"0\" x2=\"", x, "\" y2=\"", std::to_string(height - kRow),
            "\" stroke=\"#ddd\"/><text x=\"", x, "\" y=\"", std::to_string(height - 4),
            "\" text-anchor=\"middle\" fill=\"#555\">", decimal(tick / 4.0, 2), "</text>\n"});
  }
}

void append_bar(std::string& body, const HtmlReport::RateBar& bar, int y, const char* color) {
  const double length = kLength * std::clamp(bar.value, 0.0, 1.0);
  append(body, {"<text x=\"", std::to_string(kLabels - 8), "\" y=\"", std::to_string(y + 13),
                "\" text-anchor=\"end\">", escaped(bar.label), "</text><rect x=\"",
                std::to_string(kLabels), "\" y=\"", std::to_string(y + 3), "\" width=\"",
                decimal(length, 1), "\" height=\"", std::to_string(kRow - 6), "\" fill=\"", color,
                "\"/>"});
  if (bar.mark >= 0) {
    const std::string x = decimal(kLabels + kLength * std::clamp(bar.mark, 0.0, 1.0), 1);
    append(body, {"<line x1=\"", x, "\" y1=\"", std::to_string(y + 1), "\" x2=\"", x, "\" y2=\"",
                  std::to_string(y + kRow - 1), "\" stroke=\"#c00\" stroke-width=\"2\"/>"});
  }
  append(body, {"<text x=\"", std::to_string(kLabels + kLength + 8), "\" y=\"",
                std::to_string(y + 13), "\">", decimal(bar.value, 3), "</text>\n"});
}

}  // namespace

HtmlReport::HtmlReport(std::string_view title) : title_(title) {}

void HtmlReport::heading(std::string_view text) { body_ += "<h2>" + escaped(text) + "</h2>\n"; }

void HtmlReport::paragraph(std::string_view text) { body_ += "<p>" + escaped(text) + "</p>\n"; }

void HtmlReport::table(const std::vector<std::string>& header,
                       const std::vector<std::vector<std::string>>& rows) {
  body_ += "<table>\n<tr>";
  for (const std::string& cell : header) body_ += "<th>" + escaped(cell) + "</th>";
  body_ += "</tr>\n";
  for (const auto& row : rows) {
    body_ += "<tr>";
    for (const std::string& cell : row) {
      body_ += looks_like_number(cell) ? "<td class=\"number\">" : "<td>";
      body_ += escaped(cell) + "</td>";
    }
    body_ += "</tr>\n";
  }
  body_ += "</table>\n";
}

void HtmlReport::bars(const std::vector<RateBar>& bars) {
  constexpr int kWidth = kLabels + kLength + 60;
  std::vector<std::string> groups;
  for (const RateBar& bar : bars) {
    if (std::find(groups.begin(), groups.end(), bar.group) == groups.end()) {
      groups.push_back(bar.group);
    }
  }
  const int height = kRow * static_cast<int>(bars.size()) + kRow;
  body_ += "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + std::to_string(kWidth) +
           "\" height=\"" + std::to_string(height) + "\" viewBox=\"0 0 " + std::to_string(kWidth) +
           " " + std::to_string(height) + "\" font-family=\"sans-serif\" font-size=\"12\">\n";
  append_scale(body_, height);
  int y = 0;
  for (const RateBar& bar : bars) {
    const auto group = std::find(groups.begin(), groups.end(), bar.group) - groups.begin();
    append_bar(body_, bar, y, kColors[static_cast<std::size_t>(group) % kColors.size()]);
    y += kRow;
  }
  body_ += "</svg>\n<p>";
  for (std::size_t i = 0; i < groups.size(); ++i) {
    body_ += "<span style=\"color:" + std::string(kColors[i % kColors.size()]) +
             "\">&#9632;</span> " + escaped(groups[i]) + " ";
  }
  body_ += "</p>\n";
}

void HtmlReport::picture(std::string_view caption, std::span<const std::byte> png) {
  body_ += "<figure><figcaption>" + escaped(caption) + "</figcaption><img alt=\"" +
           escaped(caption) + "\" src=\"data:image/png;base64," + base64(png) + "\"></figure>\n";
}

std::string HtmlReport::text() const {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<title>" +
         escaped(title_) + "</title><style>" + kStyle + "</style></head>\n<body>\n<h1>" +
         escaped(title_) + "</h1>\n" + body_ + "</body></html>\n";
}

}  // namespace engram
