# ATOM: `make demo` shows it working, `make test` proves it. `make help` lists the rest.
PYTHON3   ?= $(shell command -v python3.11 || command -v python3)
VENV      := .venv
PY        := $(VENV)/bin/python
COMMAND   ?= find the red bottle
SEED      ?= 0
PORT_BASE ?= 8000
TOUR      ?= 1
SPEECH    ?=
COCO      ?=
PYTEST    := $(PY) -m pytest
PARALLEL  := -n 2 --dist loadfile --no-loadscope-reorder
ALONE     := tests/integration/sim tests/e2e
STACK     := --seed $(SEED) --port-base $(PORT_BASE) --command "$(COMMAND)" $(if $(filter 0,$(TOUR)),--no-tour,--tour) $(if $(filter-out 0,$(SPEECH)),--speech)

export YOLO_OFFLINE ?= 1

.DEFAULT_GOAL := help
.PHONY: help setup demo up down doctor api check format test test-fast test-e2e train models clean replay
.PHONY: bench-stop bench-faults bench-votes bench-inference bench-parser bench-speech bench-voice-stop bench-coordinator bench-campaign bench-scan bench-memory bench-calls bench-search bench-rooms bench-explore bench-fetch bench-trace trace
.PHONY: docs sbom audit
.PHONY: bench-hostile bench-soak bench-calibration test-ui screens bench-ui

help: ## list the targets
	@grep -hE '^[a-z0-9-]+:.*## ' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-16s %s\n", $$1, $$2}'

setup: ## make .venv and build the ROS interfaces (quick when nothing changed)
	@$(PYTHON3) tools/setup.py

demo: setup ## the robot finds something: COMMAND="find the red bottle" SEED=0 ONCE=1 PORT_BASE=8000 TOUR=1 SPEECH=1 (the page hears and speaks)
	@$(PY) -m demo run $(STACK) $(if $(ONCE),--once)

up: setup ## start everything without a mission (same settings as demo)
	@$(PY) -m demo up $(STACK)

down: ## end what `make up` started
	@$(PY) -m demo down --port-base $(PORT_BASE)

docs: setup ## the site, into out/site: a broken link, anchor or picture is an error (no network)
	@NO_MKDOCS_2_WARNING=1 $(VENV)/bin/mkdocs build --strict

sbom: setup ## what is installed, as CycloneDX: out/sbom/atom.cdx.json (its tool in a place of its own: it would break rclpy's parser)
	@test -x out/sbom/tool/bin/cyclonedx-py || { $(PYTHON3) -m venv out/sbom/tool && out/sbom/tool/bin/pip install -q cyclonedx-bom==7.5.0; }
	out/sbom/tool/bin/cyclonedx-py environment --output-reproducible --of JSON -o out/sbom/atom.cdx.json $(PY)

audit: setup ## known weaknesses of what is installed (asks the internet; without it that is said, and it fails)
	@$(PY) tools/audit.py

check: setup docs ## format, lint, types, images, dead wood, the site: no network, ROS, Docker or display
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/ruff check .
	$(VENV)/bin/pyright
	$(VENV)/bin/pyright -p bench
	$(VENV)/bin/hadolint --config .hadolint.yaml services/*/Dockerfile sim/Dockerfile packages/cli/Dockerfile packages/ear/Dockerfile
	$(VENV)/bin/compose-lint check -q compose.yaml
	$(VENV)/bin/vulture --min-confidence 80 --ignore-names trace services packages sim/src demo/src bench

format: ## format and mend what can be mended
	$(VENV)/bin/ruff format .
	$(VENV)/bin/ruff check --fix .

test: ## everything, the end-to-end run of the whole mesh included
	@$(PYTHON3) tools/setup.py --tests
	$(PYTEST) tests $(ALONE:%=--ignore %) $(PARALLEL)
	$(PYTEST) $(ALONE)

test-fast: setup ## unit, contract and architecture tests only
	$(PYTEST) tests/unit tests/contract tests/architecture $(PARALLEL)

test-e2e: setup ## the whole mesh with the simulated robot
	$(PYTEST) tests/e2e

bench-coordinator: setup ## how long a step and a coverage plan take: out/bench/coordinator.json and .png
	$(PY) -m bench.coordinator

bench-campaign: setup ## faulted missions through all services with the real eyes, judged: MISSIONS=500 JOBS= MINUTES=; out/bench/campaign; goes on where it was ended
	$(PY) -m bench.campaigning play --missions $(or $(MISSIONS),500) $(if $(JOBS),--jobs $(JOBS)) $(if $(MINUTES),--minutes $(MINUTES))

bench-search: setup ## searches with the robot's own eyes: EPISODES= SETS= POLICY= SETTINGS='name=value ...' HOMES=test|tune DETECTOR=sim|coco JOBS=; goes on where it was ended
	$(PY) -m bench.search play --episodes $(or $(EPISODES),20) --sets $(or $(SETS),all) --policy $(or $(POLICY),belief) \
		--homes $(or $(HOMES),test) --detector $(or $(DETECTOR),sim) $(foreach one,$(SETTINGS),--set $(one)) $(if $(JOBS),--jobs $(JOBS))

bench-rooms: setup ## maps cut into rooms, against the simulated homes' own: HOMES=50 FIRST=7020; out/bench/rooms.json and .png, the worst
	$(PY) -m bench.rooms --homes $(or $(HOMES),50) --first $(or $(FIRST),7020)

bench-explore: setup ## unknown homes explored by four policies: HOMES=3 POLICIES=sensible,frontiers,reactive,hostile,killed; resumable, out/bench/explore
	PYTHONHASHSEED=0 $(PY) -m bench.explore play --homes $(or $(HOMES),3) --policies $(or $(POLICIES),sensible,frontiers,reactive,hostile,killed) \
		--duration $(or $(DURATION),900)

bench-fetch: setup ## things of six kinds at three heights grasped by the simulated arm, by physics: FETCHES=20 FIRST=1; out/bench/fetch
	PYTHONHASHSEED=0 $(PY) -m bench.fetch --fetches $(or $(FETCHES),20) --first $(or $(FIRST),1)

bench-calls: setup ## how many HTTP calls a mission makes, by caller and route: out/bench/calls.json
	$(PY) -m bench.calls --missions $(or $(MISSIONS),6)

bench-scan: setup ## stop-look-turn against a slow turn, both measured: out/bench/scan.json
	$(PY) -m bench.scan

doctor: setup ## look at the live ROS graph: what fits, what does not, what to set (LISTEN=8 seconds; moves nothing)
	@$(PY) -m robot_bridge.doctor --seconds $(or $(LISTEN),8)

replay: setup ## decide a recorded mission again, step by step: MISSION=<file, or id in the database>
	@$(PY) -m coordinator.replay $(MISSION)

api: setup ## write docs/api from the services' own code; what breaks a caller is told, and written with BREAKING=1 only
	@$(PY) tools/api_documents.py $(if $(BREAKING),--breaking)
	@$(PY) tools/access_page.py
	@PYTHONPATH=tests:tools:. $(PY) -m support.consumer_record

trace: setup ## draw a mission from the typed word to the wheels: MISSION=<id, none = the newest> TRACES=<folder ATOM_TRACES names>
	@$(PY) tools/draw_trace.py $(MISSION) --traces $(or $(TRACES),out/demo/$(PORT_BASE)/traces)

bench-trace: setup ## what tracing costs a request: out/bench/tracing.json; and a mission with every span, drawn
	$(PY) -m bench.tracing
	$(PY) -m bench.traced_mission
	$(PY) tools/draw_trace.py --traces out/bench/traces

train: setup ## train the simulator's weights again, about three hours on two idle cores
	$(PY) -m sim.training.dataset out/training/homes --first 100000 --homes 700 --images 10
	$(PY) -m sim.training.dataset out/training/held_out --first 900000 --homes 60 --images 8
	$(PY) -m sim.training.detector out/training/homes sim/weights/detector.pt --steps 20000 --threads 2
	$(PY) -m sim.training.clip out/training/homes sim/weights/clip.safetensors --held-out out/training/held_out
	$(PY) -m sim.training.evaluate out/training/held_out --weights sim/weights

bench-stop: setup ## curl to the first zero Twist in another ROS process: 500 times idle, 500 loaded (about 6 minutes); SECURED=1: with keys and traces on; SPEECH=1: beside a speech service that listens
	$(PY) -m bench.stop $(if $(SECURED),--secured) $(if $(SPEECH),--speech)

bench-faults: setup ## do to the running mesh what may happen to it, and tell what the robot did (about 6 minutes)
	$(PY) -m bench.faults
	$(PY) -m bench.faults --quick clock_stepped --out out/bench/faults_clock.json

bench-hostile: setup ## hostile requests to every service of the running mesh, stops asked meanwhile: REQUESTS=100000 MINUTES=240; out/bench/hostile.json
	$(PY) -m bench.hostile --requests $(or $(REQUESTS),100000) --minutes $(or $(MINUTES),240)

bench-soak: setup ## missions one after another, two viewers of the page: does any process grow? MINUTES=120; out/bench/soak.json and .png
	$(PY) -m bench.soak --minutes $(or $(MINUTES),120)

bench-votes: setup ## the votes on held-out homes: COCO=folder of a COCO detector to judge beside ours
	$(PY) -m bench.votes $(if $(COCO),--coco $(COCO))

bench-calibration: setup ## what each vote is worth, on held-out pictures: DATA=folder of sim.training.dataset; writes sim/weights/calibration.json
	$(PY) -m bench.calibration $(DATA)

bench-parser: setup ## how well commands are read, by the rules and by the language model INFERENCE_* names
	$(PY) -m bench.parser

bench-speech: setup ## spoken commands, spoiled, heard by Whisper: understood, asked back, wrong; SECONDS= (0 = report alone); goes on where it was ended
	nice -n 10 $(PY) -m bench.speech $(if $(SECONDS),--seconds $(SECONDS))

bench-voice-stop: setup ## a spoken stop: how soon, how often missed, how often heard where nobody said it: ROUNDS=3 BUSY=2 SECONDS= (of other speech); goes on where it was ended
	$(PY) -m bench.voice_stop --rounds $(or $(ROUNDS),3) --busy $(or $(BUSY),2) $(if $(SECONDS),--seconds $(SECONDS))

models: setup ## fetch the models of a real robot: COCO detector, CLIP ViT-B/32, Ollama's (MIRROR=http://nas.lan/models)
	@$(PY) tools/models.py $(if $(MIRROR),--mirror $(MIRROR))

bench-inference: setup ## backends, overhead, latency, throughput and memory of the inference service (about 8 minutes)
	$(PY) -m bench.inference

bench-memory: setup ## a simulated year of sightings, beside a JSON file: out/bench/memory.json (about 10 minutes)
	$(PY) -m bench.memory_scale
	$(PY) -m bench.memory_kills
	$(PY) -m bench.memory_story

test-ui: ## the operator's page in real Chromium: on fakes, then against the running mesh
	@$(PYTHON3) tools/setup.py --tests
	$(PYTEST) tests/integration/ui tests/e2e/test_page.py tests/e2e/test_voice.py tests/e2e/test_belief.py

screens: setup ## write docs/screens anew: the pictures of the page that the tests take
	ATOM_SCREENS=docs/screens $(PYTEST) tests/e2e/test_page.py tests/e2e/test_voice.py tests/e2e/test_belief.py

bench-ui: setup ## the page: a frame's way from the bridge to the screen, CPU for 1, 5 and 20 viewers (about 4 minutes)
	$(PY) -m bench.ui

clean: ## remove what can be made again, but the environment
	rm -rf out .ruff_cache .hypothesis
