#include "mjcf/carrier.h"

namespace engram::mjcf {
namespace {

constexpr const char* kFrame = "carrier_frame";
constexpr double kSiteSize = 0.004;  // m

std::string site_name(const std::string& body_name) { return body_name + "_carrier"; }

Element& add_site(Element& body, const std::string& name, const Vec3& pos) {
  Element& site = add(body, "site");
  set(site, "name", name);
  set(site, "pos", pos);
  set(site, "size", kSiteSize);
  set(site, "group", 4);  // hidden by viewers by default
  return site;
}

}  // namespace

void add_carrier_frame(Element& worldbody) { add_site(worldbody, kFrame, {}); }

void add_carrier_site(Element& body, const std::string& body_name, const Vec3& center_of_mass) {
  add_site(body, site_name(body_name), center_of_mass);
}

void add_carrier(Element& actuators, const std::string& body_name, double mass) {
  Element& carrier = add(actuators, "general");
  set(carrier, "name", site_name(body_name));
  set(carrier, "site", site_name(body_name));
  set(carrier, "refsite", kFrame);
  set(carrier, "gear", {0, 0, 1, 0, 0, 0});
  set(carrier, "gainprm", 0);
  set(carrier, "biastype", "affine");
  set(carrier, "biasprm", {kGravity * mass, 0, 0});
}

}  // namespace engram::mjcf
