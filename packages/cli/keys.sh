#!/bin/sh
# keys [make NAME --role admin | list | revoke NAME ...]: `atom keys` on the volume of all keys, then each service gets its own.
# Without words it makes the services' keys that are missing, and prints none.
set -eu
if [ $# -gt 0 ]; then atom keys "$@"; else atom keys make --services; fi

lay() { # whole or not at all: a service may read it at any time
  [ -f "$ATOM_KEYS_FOLDER/$1" ] || return 0 # revoked
  cp "$ATOM_KEYS_FOLDER/$1" "$to/.new" && chmod 444 "$to/.new" && mv "$to/.new" "$to/$1"
}
beside=${ATOM_KEYS_FOLDER%/*}
for service in coordinator inference memory robot_bridge speech ui; do
  to=$beside/$service
  lay keys.json
  lay $service.key
done
to=$beside/ear; lay ear.key # it asks, and is asked by nobody
to=$beside/redis; lay redis.acl
to=$beside/prometheus; lay prometheus.key
[ $# -gt 0 ] || echo "The services have their keys. Yours: docker compose run --rm keys make YOUR_NAME --role admin"
