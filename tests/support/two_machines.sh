# Run by tests/integration/robot_bridge/test_two_machines.py in a network, mount and pid namespace of its own:
# the toy robot on a machine of its own on a cable, or beside the bridge on the host's network as containers are.
# $1 cable, server or beside; $2 the Python; $3 a folder. Nothing of it outlives this script.
set -euo pipefail
ip link set lo up
robot=(unshare --mount)
if [ "$1" != beside ]; then
  unshare --net sleep infinity &
  until [ "$(readlink /proc/$!/ns/net)" != "$(readlink /proc/self/ns/net)" ]; do :; done
  ip link add computer type veth peer name robot netns $!
  ip address add 10.9.0.1/24 dev computer
  ip link set computer up
  robot=(nsenter --net=/proc/$!/ns/net)
  "${robot[@]}" ip link set lo up
  "${robot[@]}" ip address add 10.9.0.2/24 dev robot
  "${robot[@]}" ip link set robot up
fi
if [ "$1" = server ]; then
  "${robot[@]}" "$(dirname "$2")/fast-discovery-server" -i 0 -l 10.9.0.2 -p 11811 >/dev/null &
  export ROS_DISCOVERY_SERVER=10.9.0.2:11811
fi
if [ "$1" = beside ]; then
  robot+=(sh -c 'mount -t tmpfs robot /dev/shm && exec "$@"' sh)
fi
"${robot[@]}" "$2" -m support.discovery_scene robot "$3" &
FASTRTPS_DEFAULT_PROFILES_FILE=${BRIDGE_PROFILE} "$2" -m support.discovery_scene bridge "$3"
