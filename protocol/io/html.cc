#include "protocol/io/html.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <set>

#include "protocol/io/decimal.h"

namespace engram {
namespace {

constexpr const char* kStyle = R"css(
:root { color-scheme: light dark; --ink: #222; --soft: #555; --line: #ddd; --back: #fff;
        --mark: #c00; --g0: #4878a8; --g1: #c8803c; --g2: #5c9c5c; --g3: #a05c98; --g4: #98864c;
        --g5: #8c8c8c }
@media (prefers-color-scheme: dark) {
  :root { --ink: #eceae6; --soft: #a9adb5; --line: #3a3e45; --back: #15171a; --mark: #ff7a70;
          --g0: #6f9fcf; --g1: #d99a5c; --g2: #7dbd7d; --g3: #c684be; --g4: #bba972; --g5: #a8a8a8 }
}
body { font: 15px/1.45 system-ui, sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em;
       color: var(--ink); background: var(--back) }
h1 { font-size: 1.5em } h2 { font-size: 1.15em; margin-top: 2em }
h1, p, figcaption { overflow-wrap: anywhere }
.scroll { overflow-x: auto }
table { border-collapse: collapse; font-size: 13px }
th, td { padding: 2px 10px; border-bottom: 1px solid var(--line); text-align: left }
td { white-space: nowrap }
td.number { text-align: right; font-variant-numeric: tabular-nums }
.facts td { white-space: normal; overflow-wrap: anywhere; text-align: left }
.bar { display: grid; grid-template-columns: 20em 1fr 3em; gap: 0 .7em; align-items: center;
       font-size: 13px; line-height: 1.3; margin: .25em 0 }
.bar .label { text-align: right; overflow-wrap: anywhere }
.bar .value { font-variant-numeric: tabular-nums }
.track { position: relative; height: 1em; border-right: 1px solid var(--line);
         background: repeating-linear-gradient(
         90deg, var(--line) 0 1px, transparent 1px 25%) }
.track i { display: block; height: 100% }
.track u { position: absolute; top: 50%; height: 2px; margin-top: -1px; background: var(--ink) }
.track b { position: absolute; top: -2px; bottom: -2px; width: 2px; background: var(--mark) }
@media (max-width: 45em) {
  body { margin: 1em auto }
  .bar { grid-template-columns: 1fr 3em; margin: .5em 0 }
  .bar .label { grid-column: 1 / -1; text-align: left }
}
svg { max-width: 100%; font-size: 12px; font-variant-numeric: tabular-nums }
svg text { fill: var(--soft) }
figure { margin: 0 0 1em } figcaption { font-size: 13px; color: var(--soft) }
img { max-width: 100%; image-rendering: pixelated }
)css";

constexpr std::size_t kColors = 6;  // --g0 to --g5

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

std::string percent(double rate) { return decimal(100 * std::clamp(rate, 0.0, 1.0), 1) + "%"; }

std::string color(std::size_t group) { return "var(--g" + std::to_string(group % kColors) + ")"; }

void append_bar(std::string& body, const HtmlReport::RateBar& bar, std::size_t group) {
  append(body, {"<div class=\"bar\"><span class=\"label\">", escaped(bar.label),
                "</span><span class=\"track\"><i style=\"width:", percent(bar.value),
                ";background:", color(group), "\"></i>"});
  if (bar.low >= 0) {
    append(body, {"<u style=\"left:", percent(bar.low), ";width:", percent(bar.high - bar.low),
                  "\"></u>"});
  }
  if (bar.mark >= 0) append(body, {"<b style=\"left:", percent(bar.mark), "\"></b>"});
  append(body, {"</span><span class=\"value\">", decimal(bar.value, 3), "</span></div>\n"});
}

// A chart of rates as SVG. Lengths are in pixels.
class CurveChart {
 public:
  CurveChart(const std::vector<HtmlReport::Curve>& curves, const HtmlReport::CurveAxes& axes)
      : curves_(curves), axes_(axes) {
    for (const HtmlReport::Curve& curve : curves_) {
      for (const HtmlReport::CurvePoint& point : curve.points) quantities_.insert(point.x);
    }
  }

  std::string text() const {
    std::string svg = "<svg role=\"img\" aria-label=\"rates over " + escaped(axes_.quantity) +
                      "\" viewBox=\"0 0 " + px(kWidth) + " " + px(kHeight) + "\" width=\"" +
                      px(kWidth) + "\">\n";
    append_axes(svg);
    for (std::size_t i = 0; i < curves_.size(); ++i) append_curve(svg, curves_[i], i);
    return svg + "</svg>\n" + legend();
  }

 private:
  static constexpr double kWidth = 560;
  static constexpr double kHeight = 240;
  static constexpr double kLeft = 40;
  static constexpr double kRight = 20;
  static constexpr double kTop = 10;
  static constexpr double kBottom = 40;

  static std::string px(double length) { return decimal(length, 1); }
  double scaled(double x) const { return axes_.logarithmic ? std::log1p(x) : x; }
  double x_of(double quantity) const {
    const double from = scaled(*quantities_.begin());
    const double range = scaled(*quantities_.rbegin()) - from;
    const double share = range > 0 ? (scaled(quantity) - from) / range : 0.5;
    return kLeft + share * (kWidth - kLeft - kRight);
  }
  static double y_of(double rate) {
    return kTop + (1 - std::clamp(rate, 0.0, 1.0)) * (kHeight - kTop - kBottom);
  }

  static void append_line(std::string& svg, double x1, double y1, double x2, double y2,
                          std::string_view stroke, std::string_view width) {
    append(svg, {"<line x1=\"", px(x1), "\" y1=\"", px(y1), "\" x2=\"", px(x2), "\" y2=\"", px(y2),
                 "\" stroke=\"", stroke, "\" stroke-width=\"", width, "\"/>\n"});
  }
  static void append_text(std::string& svg, double x, double y, std::string_view anchor,
                          std::string_view text) {
    append(svg, {"<text x=\"", px(x), "\" y=\"", px(y), "\" text-anchor=\"", anchor, "\">",
                 escaped(text), "</text>\n"});
  }

  void append_axes(std::string& svg) const {
    for (int quarter = 0; quarter <= 4; ++quarter) {
      const double rate = quarter / 4.0;
      append_line(svg, kLeft, y_of(rate), kWidth - kRight, y_of(rate), "var(--line)", "1");
      append_text(svg, kLeft - 6, y_of(rate) + 4, "end", decimal(rate, 2));
    }
    if (axes_.mark >= 0) {
      append_line(svg, kLeft, y_of(axes_.mark), kWidth - kRight, y_of(axes_.mark), "var(--mark)",
                  "1.5");
    }
    for (const double x : quantities_) {
      append_text(svg, x_of(x), kHeight - kBottom + 16, "middle", decimal(x, 0));
    }
    append_text(svg, (kLeft + kWidth - kRight) / 2, kHeight - 6, "middle", axes_.quantity);
  }

  void append_curve(std::string& svg, const HtmlReport::Curve& curve, std::size_t group) const {
    const std::string stroke = color(group);
    std::string line;
    // Curves stand beside one another, so that their intervals can be told apart.
    const double shift = 3.0 * static_cast<double>(group);
    for (const HtmlReport::CurvePoint& point : curve.points) {
      const double x = x_of(point.x) + shift;
      append_line(svg, x, y_of(point.low), x, y_of(point.high), stroke, "1");
      append(svg, {"<circle cx=\"", px(x), "\" cy=\"", px(y_of(point.y)), "\" r=\"3\" fill=\"",
                   stroke, "\"/>\n"});
      line += px(x) + "," + px(y_of(point.y)) + " ";
    }
    append(svg, {"<polyline points=\"", line, "\" fill=\"none\" stroke=\"", stroke,
                 "\" stroke-width=\"2\"/>\n"});
  }

  std::string legend() const {
    std::string text = "<p>";
    for (std::size_t i = 0; i < curves_.size(); ++i) {
      append(text, {"<span style=\"color:", color(i), "\">&#9632;</span> ",
                    escaped(curves_[i].name), " "});
    }
    return text + "</p>\n";
  }

  const std::vector<HtmlReport::Curve>& curves_;
  const HtmlReport::CurveAxes& axes_;
  std::set<double> quantities_;
};

}  // namespace

std::string counted(std::size_t count, std::string_view what) {
  return std::to_string(count) + " " + std::string(what) + (count == 1 ? "" : "s");
}

HtmlReport::HtmlReport(std::string_view title) : title_(title) {}

void HtmlReport::heading(std::string_view text) { body_ += "<h2>" + escaped(text) + "</h2>\n"; }

void HtmlReport::paragraph(std::string_view text) { body_ += "<p>" + escaped(text) + "</p>\n"; }

void HtmlReport::table(const std::vector<std::string>& header,
                       const std::vector<std::vector<std::string>>& rows) {
  const bool facts = std::ranges::all_of(header, &std::string::empty);
  // Wide tables scroll by themselves, also by keyboard, and the page stays as wide as the screen.
  body_ +=
      facts ? "<table class=\"facts\">\n" : "<div class=\"scroll\" tabindex=\"0\"><table>\n<tr>";
  if (!facts) {
    for (const std::string& cell : header) body_ += "<th>" + escaped(cell) + "</th>";
    body_ += "</tr>\n";
  }
  for (const auto& row : rows) {
    body_ += "<tr>";
    for (const std::string& cell : row) {
      body_ += looks_like_number(cell) ? "<td class=\"number\">" : "<td>";
      body_ += escaped(cell) + "</td>";
    }
    body_ += "</tr>\n";
  }
  body_ += facts ? "</table>\n" : "</table></div>\n";
}

void HtmlReport::bars(const std::vector<RateBar>& bars) {
  std::vector<std::string> groups;
  for (const RateBar& bar : bars) {
    auto group = std::find(groups.begin(), groups.end(), bar.group);
    if (group == groups.end()) group = groups.insert(group, bar.group);
    append_bar(body_, bar, static_cast<std::size_t>(group - groups.begin()));
  }
  body_ += "<p>";
  for (std::size_t i = 0; i < groups.size(); ++i) {
    append(body_,
           {"<span style=\"color:", color(i), "\">&#9632;</span> ", escaped(groups[i]), " "});
  }
  body_ += "</p>\n";
}

void HtmlReport::curves(const std::vector<Curve>& curves, const CurveAxes& axes) {
  body_ += CurveChart(curves, axes).text();
}

void HtmlReport::image(std::string_view caption, std::span<const std::byte> png) {
  body_ += "<figure><figcaption>" + escaped(caption) + "</figcaption><img alt=\"" +
           escaped(caption) + "\" src=\"data:image/png;base64," + base64(png) + "\"></figure>\n";
}

std::string HtmlReport::text() const {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         escaped(title_) + "</title><style>" + kStyle + "</style></head>\n<body>\n<h1>" +
         escaped(title_) + "</h1>\n" + body_ + "</body></html>\n";
}

}  // namespace engram
