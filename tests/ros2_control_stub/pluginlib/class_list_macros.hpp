// The least of ros2_control that a transmission is compiled with in tests; not for robots.
#pragma once
#include <memory>
#define PLUGINLIB_EXPORT_CLASS(Class, Base) \
  std::unique_ptr<Base> exported_plugin() {return std::make_unique<Class>();}
