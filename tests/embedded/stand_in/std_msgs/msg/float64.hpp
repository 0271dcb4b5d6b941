// Stands in for the message of ROS 2; see rclcpp.hpp.
#pragma once

namespace std_msgs::msg
{
struct Float64 {
  double data;
};
}  // namespace std_msgs::msg
