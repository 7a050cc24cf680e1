# The steps of deploy/demo.sh. Expects: root, here, out, noise, seed, real.
bin=$root/build/release/bin
domain=$((1 + $$ % 200)) # so that two demos on one machine do not mix

say() { printf '== %3s s  %s\n' "$SECONDS" "$*"; }
stop() { printf 'demo: %s\n' "$*" >&2; exit 1; }

build_programs() {
  say "building (the first time takes a few minutes)"
  (cd "$root" && cmake --preset release >"/tmp/meshloop-demo-$$.log" 2>&1) ||
    { cat "/tmp/meshloop-demo-$$.log" >&2; stop "the build could not be configured"; }
  rm -f "/tmp/meshloop-demo-$$.log"
  cmake --build "$root/build/release" --target meshloop-station meshloop-device
}

# An old result is removed only where an old result is, and nothing is built for a folder that cannot be used.
check_out() {
  [ -n "$1" ] || stop "--out needs the name of a folder"
  if [ -e "$1" ] && [ ! -e "$1/.meshloop-demo" ] && [ -n "$(ls -A "$1" 2>&1)" ]; then
    stop "'$1' is there and is no earlier demo's folder; name another with --out"
  fi
  mkdir -p "$1" 2>/dev/null && [ -w "$1" ] || stop "the folder '$1' cannot be made or written; name another with --out"
}

prepare_out() {
  rm -rf "$1"
  mkdir -p "$1/data" "$1/device" "$1/views" && touch "$1/.meshloop-demo"
}

make_simulated_data() {
  say "simulating a scene, a Kinect and a handheld camera"
  "$bin/meshloop-station" simulate --out "$out/data" --noise "$noise" --seed "$seed"
  model=$out/data/model.ply station=$out/data/station device=$out/data/device
  device_first=$out/data/device_before_move device_last=$out/data/device_after_move
  start=(--markers "$out/data/markers.yaml")
  device_start=markers:$out/data/markers.yaml
  object=(--object-at 0.02,0.16,0 --object-height 0.3)
}

make_real_data() {
  say "converting the real sequence"
  python3 "$here/convert_castel.py" /usr/share/visp-images-data/ViSP-images/mbt-depth/castel "$out/data"
  model=$out/data/model.obj station=$out/data device=$station device_first=$station
  start=(--init "pose:$(cat "$out/data/start_pose.txt")")
  device_start=pose:$(cat "$out/data/start_pose.txt")
  object=(--object-at=-0.042,0.081,-0.065 --object-up 0,1,0 --object-height 0.07)
}

# wait_for SECONDS PATTERN FILE PID: until FILE has a line with PATTERN; fails when the process ends before.
wait_for() {
  local until=$((SECONDS + $1))
  until grep -q "$2" "$3" 2>/dev/null; do
    [ $SECONDS -lt $until ] || stop "waited $1 s in vain for $2 in $3"
    kill -0 "$4" 2>/dev/null || stop "the program that writes $3 ended early; see ${3%.*}.log"
    sleep 0.1
  done
}

run_loop() {
  say "the loop: the station plays its recording; the device joins when the first revision is there"
  "$bin/meshloop-station" scene import --scene "$out/scene.db" "$model"
  "$bin/meshloop-station" run --scene "$out/scene.db" --name demo --domain $domain --source "recording:$station" \
    "${start[@]}" --accept all --out "$out/station" --serve -1 --json >"$out/station.jsonl" 2>"$out/station.log" &
  local station_pid=$!
  trap 'kill $(jobs -p) 2>/dev/null || true' EXIT
  wait_for 60 '"event":"revision"' "$out/station.jsonl" $station_pid
  "$bin/meshloop-device" run --scene demo --domain $domain --camera "recording:$device" --loop \
    --display "offscreen:$out/device" --every 30 --init "$device_start" "${object[@]}" \
    --report "$out/device.json" --json >"$out/device.jsonl" 2>"$out/device.log" &
  local device_pid=$!
  wait_for 120 '"event":"end"' "$out/station.jsonl" $station_pid
  local last
  last=$(grep '"event":"end"' "$out/station.jsonl" | grep -o '"revision":[0-9]*' | cut -d: -f2)
  wait_for 30 "\"event\":\"drawn\",.*\"revision\":$last[,}]" "$out/device.jsonl" $device_pid
  kill -TERM $device_pid && wait $device_pid || stop "the device failed; see $out/device.log"
  kill -TERM $station_pid && wait $station_pid || stop "the station failed; see $out/station.log"
  say "revision $last is drawn on the device"
}

# track NAME MODEL RECORDING: tracks and draws in batch, into views/NAME and NAME.json
track() {
  "$bin/meshloop-device" track --model "$2" --recording "$3" --init "$device_start" --out "$out/views/$1.txt" \
    --draw "$out/views/$1" --every "$view_every" "${object[@]}" --json >"$out/views/$1.json"
}

# track_before_and_after NAME REVISION REVISION RECORDING
track_before_and_after() {
  track "$1_before" "$out/data/revision_$2.glb" "$4" &
  local before=$!
  track "$1_after" "$out/data/revision_$3.glb" "$4" &
  both $before $! "tracking ($1)"
}

# detect NAME MODEL FRAMES: the station's frames against a model, scored against the truth
detect() {
  "$bin/meshloop-station" detect --model "$2" --recording "$station" "${start[@]}" --frames "$3" \
    --truth "$out/data/station_truth" --out "$out/detect_$1" --json >"$out/detect_$1.json"
}

# both PID PID WHAT: waits for two jobs.
both() {
  wait "$1" || stop "$3 failed"
  wait "$2" || stop "$3 failed"
}

export_revisions() {
  mapfile -t revisions < <(python3 "$here/lib/revisions.py" "$out/station.jsonl")
  for revision in "${revisions[@]}"; do
    "$bin/meshloop-station" scene export --scene "$out/scene.db" --revision "$revision" "$out/data/revision_$revision.glb"
  done
  "$bin/meshloop-station" scene log --scene "$out/scene.db" --json >"$out/log.json"
}

measure_simulated() {
  view_every=5
  say "detection against the exact truth"
  # Frames in which the camera dwells; between them it moves faster than anyone would capture.
  detect first "$model" 0-2,11-13,22-25,34-37,46-49 &
  local one=$!
  detect moved "$out/data/model_before_move.ply" 60-61,70-73,82-85,94-96,106-109 &
  both $one $! "detection"
  say "tracking on a full circle, with the model before and after each adjustment"
  export_revisions
  track_before_and_after insertion "${revisions[0]}" "${revisions[1]}" "$device_first"
  track_before_and_after move "${revisions[1]}" "${revisions[2]}" "$device_last"
}

measure_real() {
  view_every=1
  say "tracking with the model before and after the adjustment"
  export_revisions
  track_before_and_after insertion "${revisions[0]}" "${revisions[2]}" "$device_first"
}
