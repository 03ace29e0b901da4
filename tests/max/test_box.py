"""What a box in Max does beside its object: inlets, time, files, buffers, what externals share."""
import array
import pathlib

import pytest

from max_host import BUILD, RATE, declarations, load, run

ROOT = pathlib.Path(__file__).resolve().parents[2]
STAGE = BUILD / "tactus"
ON = [f"rate {RATE}", "vector 64"]


def clarinet(*lines):
    return run([load("greed~"), *ON, "new b greed~ -preset clarinet", *lines])


@pytest.fixture(name="peaks")
def peaks_of_the_left_outlet(tmp_path):
    """A function: what box b plays in each so many vectors of 64 samples, with audio on."""
    def peaks(*lines, vectors=400):
        clarinet(f"record b {tmp_path}/sound", *lines)
        samples = array.array("d", (tmp_path / "sound").read_bytes())[::4]
        return [max(map(abs, samples[i:i + 64 * vectors])) for i in range(0, len(samples), 64 * vectors)]
    return peaks


def test_a_number_is_the_signal_of_an_inlet_without_one(peaks):
    def played(*lines):
        return peaks(*lines, "dsp on", "run 400")
    blown = played("send b 0 float 3000.")
    assert blown[0] > 0.1
    assert played("send b 1 float 3000.")[0] < 1e-6  # not blown
    assert played("signal b 0 constant 0", "send b 0 float 3000.")[0] < 1e-6  # a signal stands above the number
    assert played("send b 0 int 3000") == played("send b 0 list 3000. 0. 0.") == blown
    right = played("send b 0 float 3000.", "send b 2 float 90.")
    assert played("send b 0 float 3000.", "send b 2 list 90. 3.") == right != blown  # its first number alone
    middle = ["send b 0 float 3000.", "send b 2 float 90."]
    assert played(*middle, "send b 1 list 400. 20.") == played(*middle, "send b 1 float 400.") != right


def test_control_inlets_take_numbers_and_lists():
    result = run([load("phantom"), "new b phantom", "send b 2 float 1.5", "send b 1 int 2", "send b 0 float 0.25",
                  "send b 0 list 1. 2. 3.", "send b 1 list 4.", "send b 0 bang", "advance 50"])
    assert not result.of("error") and result.sent("b")
    whole = run([load("stress_haptic"), "new b stress_haptic", "send b 1 list 1. 2.", "send b 1 float 5.",
                 "send b 1 list 1. 2. 3."]).of("error")
    assert [error.split(":")[2] for error in whole] == [" 2 numbers", " 1 numbers"], whole


def test_a_list_to_the_left_inlet_gives_the_right_one_its_number_first():
    """The left inlet of a map asks for the value at both."""
    result = run([load("playability_map"), "new b playability_map trumpet @columns 3 @rows 3 @quantity growth",
                  "send b 0 compute", 'wait "b 3 float 1.0"', "send b 1 float 0.7", "send b 0 float 0.5", "send b 1 float 0.1",
                  "send b 0 list 0.5 0.7"])
    one, other = result.sent("b", 0)
    assert one[2] == other[2] and result.sent("b", 1)[0][2] == result.sent("b", 1)[1][2]


def test_lists_and_bangs_that_mean_nothing_are_one_error_that_names_what_there_is():
    result = run([load("greed_gradient~"), "new b greed_gradient~", "send b 0 bang", "send b 0 list 1. word",
                  "send b 0 list 1. 2. 3. 4.", "send b 0 list 1. 2. 3.", load("ioa_link"), "new c ioa_link",
                  "send c 0 float 5.", "send c 0 list 5. 6.", "send c 0 bang"])
    errors = result.of("error")
    assert len(errors) == 6, errors
    assert "no message 'bang'; there are preset, range and reset" in errors[0]
    assert "list: 'word': not a number: expected one for each inlet: y, z, f_b (Hz)" in errors[1]
    assert "list: 4 numbers: expected at most 3" in errors[2]
    assert "no message 'float'; there are send" in errors[3] and "no message 'list'" in errors[4]


def test_a_symbol_is_a_message_and_a_message_an_attribute_argument():
    gets = [f"get b {p['name']}" for p in declarations()["greed~"]["parameters"]]
    trumpet = run([load("greed~"), "new b greed~ -preset trumpet", *gets])
    assert run([load("greed~"), "new b greed~ @preset trumpet", *gets]).lines == trumpet.lines
    assert len(trumpet.of("value")) == len(gets) and not trumpet.of("error")
    said = clarinet("send b 0 symbol dump", "send b 0 symbol tongu")
    assert len(said.sent("b")) > len(gets) and len(said.of("error")) == 1 and "tongu" in said.of("error")[0]


def test_get_answers_to_every_name_that_dump_sends_and_preset_comes_first():
    dumped = [atoms for _, _, atoms in clarinet("send b 0 dump").sent("b")]
    names = list(dict.fromkeys(atoms[0] for atoms in dumped))
    assert names[0] == "preset" and len(names) > 60
    answers = clarinet(*(f"send b 0 get {name}" for name in names))
    assert [atoms for _, _, atoms in answers.sent("b")] == [atoms for name in names for atoms in dumped if atoms[0] == name]
    assert not answers.of("error")
    asked = run([load("greed~"), "new b greed~", "send b 0 get preset", "send b 0 get gian"]).of("error")
    assert len(asked) == 2 and "get preset: a message has no value" in asked[0]
    assert "get gian: unknown name; did you mean 'gain'?" in asked[1]


def shown(result):
    """attribute -> the value of each time that the box has said it has changed."""
    lines = [line.split(" ") for line in result.of("shown")]
    return {name: [value for _, other, value in lines if other == name] for name in {line[1] for line in lines}}


@pytest.mark.parametrize("audio", ["on", "off"])
def test_whoever_shows_an_attribute_learns_what_else_has_changed_it(audio):
    def played(*lines):
        return clarinet(f"dsp {audio}", *lines)
    assert not played().of("shown")  # a new box has shown nothing before
    gets = [f"get b {p['name']}" for p in declarations()["greed~"]["parameters"]]
    before = played(*gets).values("b")
    result = played("send b 0 preset trumpet", "run 2", *gets)
    after = result.values("b")
    changed = {name: [value] for name, value in after.items() if value != before[name]}
    assert len(changed) > 10 and shown(result) == changed
    assert set(result.of("notified")) == {"b modified"}
    # Of an attribute that is set, Max says so itself; a type turns the rest angle's sign.
    own = played("send b 0 gain 0.5", "run 2")
    assert not own.of("shown") and own.of("notified") == ["b modified"]
    sign = played("send b 0 type open", "run 2", "get b theta0")
    assert shown(sign) == {"theta0": [sign.values("b")["theta0"]]}
    same = run([load("greed~"), *ON, "new b greed~ @gain 0.5", f"dsp {audio}", "send b 0 gain 0.5", "run 2"])
    assert not same.of("notified")
    # Many changes are told at once, when Max has time.
    late = played("send b 0 preset oboe", "send b 0 preset trumpet", "echo then", "run 2", *gets)
    told = [line for line in late.lines if line.startswith(("shown", "then", "notified"))]
    assert told[0] == "then" and late.of("notified") == ["b modified"]
    assert shown(late).items() >= changed.items()  # and what the oboe has changed and the trumpet back
    assert all(values == [after[name]] for name, values in shown(late).items())


def test_neither_a_preset_nor_a_saved_patcher_switches_motors_on():
    box = [load("phantom"), "new b phantom"]
    parameters = [p for p in declarations()["phantom"]["parameters"] if p["name"] != "motors"]
    stored = run([*box, "value b"]).of("whole")[0].removeprefix("b ")
    assert len(stored.split()) == len(parameters)
    result = run([*box, "send b 0 motors 0", f"value b {stored}", "get b motors", "class phantom"])
    assert result.values("b")["motors"] == "0.0"
    assert "save=1" not in next(line for line in result.of("attribute") if " motors " in line)


def test_a_muted_object_is_silent_and_goes_on(peaks):
    played = peaks("signal b 0 constant 3000", "dsp on", "run 200", "mute b 1", "run 100", "mute b 0", "run 100", vectors=100)
    assert min(played[1], played[3]) > 0.1 and played[2] == 0


def test_realtime_messages_wait_for_the_next_block_and_for_no_longer_than_audio_runs():
    def said(*lines):
        """Where the refusals stand among the echoes."""
        result = run([load("contact_impact~"), *ON, "new b contact_impact~", "dsp on", "run 4", *lines])
        assert all("nothing falls" in error for error in result.of("error"))
        return [line.split(":")[0] for line in result.lines if line.startswith(("error", "later"))]
    assert said("send b 0 drop 5.", "echo later", "run 2") == ["later", "error"]  # by the audio thread, in its block
    assert said("send b 0 drop 5.", "dsp off", "advance 300", "echo later") == ["error", "later"]
    # One more, when blocks have come since the first was sent, and none comes any more.
    assert said("send b 0 drop 5.", "run 20", "send b 0 drop 5.", "dsp off", "echo later", "advance 300") == \
        ["error", "later", "error"]
    assert said("mute b 1", "send b 0 drop 5.", "echo later") == ["error", "later"]


def test_outputs_of_audio_leave_by_a_clock():
    result = run([load("contact_impact~"), *ON, "new b contact_impact~", "dsp on", "send b 0 strike 1.", "run 100"])
    impacts = result.sent("b", 2)
    assert impacts and impacts[0][2][0] == "list" and len(impacts[0][2]) == 3


def test_neither_a_new_chain_nor_the_length_of_vectors_changes_the_sound(tmp_path):
    """Connecting another cord calls dsp64 anew."""
    def sound(size, *between):
        clarinet(f"vector {size}", "signal b 0 constant 3000", "send b 2 float 200.", "dsp on", f"record b {tmp_path}/sound",
                 f"run {8192 // size}", *between, f"run {8192 // size}", "dsp off")
        return (tmp_path / "sound").read_bytes()
    plain = sound(64)
    assert sound(64, "signal b 1 constant 0", "signal b 1 none") == plain
    assert all(sound(size) == plain for size in (1, 2048, 8192))


@pytest.mark.parametrize("thread", ["main", "scheduler"])
def test_files_are_found_by_every_name(thread, tmp_path):
    body = (STAGE / "plate.modal.npz").read_bytes()
    (tmp_path / "beside").mkdir()
    (tmp_path / "beside" / "mine.modal.npz").write_bytes(body)
    (tmp_path / "flat").mkdir()
    (tmp_path / "flat" / "drop.txt").write_bytes((ROOT / "data" / "networks" / "drop.txt").read_bytes())

    def loads(object_, message, *set_up):
        result = run([load(object_), *set_up, f"new b {object_}", f"thread {thread}", f"send b 0 {message}", "thread main",
                      "advance 20"])
        return result.of("error")

    assert not loads("modal_impact~", "load plate.modal.npz -sync", f"searchpath {STAGE}")
    assert not loads("modal_impact~", "load mine.modal.npz -sync", f"patcher {tmp_path}/beside/a.maxpat")
    assert not loads("modal_impact~", f"load {STAGE}/plate.modal.npz -sync")
    assert not loads("phantom", "network load networks/drop.txt", f"searchpath {STAGE}")
    assert not loads("phantom", "network load networks/drop.txt", f"searchpath {tmp_path}/flat")
    # In the scheduler's thread a word that is no file's name to look at is sought beside the patcher alone.
    (tmp_path / "beside" / "mine").write_bytes(body)
    assert not loads("modal_impact~", "load mine -sync", f"patcher {tmp_path}/beside/a.maxpat")
    missing = loads("modal_impact~", "load no-such.npz -sync", f"searchpath {STAGE}")
    assert len(missing) == 1 and "no-such.npz" in missing[0]


@pytest.mark.parametrize("where", ["", " subpatcher"])
def test_files_lie_beside_the_patcher_also_those_of_a_subpatcher(where, tmp_path):
    result = run([load("phantom"), f"patcher {tmp_path}/a.maxpat{where}", "new b phantom", "send b 0 trace t.csv",
                  "advance 50", "send b 0 trace stop", "free b"])
    assert not result.of("error") and (tmp_path / "t.csv").stat().st_size > 0
    later = run([load("phantom"), "new b phantom", f"patcher {tmp_path}/saved.maxpat{where}", "send b 0 trace later.csv",
                 "advance 50", "send b 0 trace stop", "free b"])  # saved after the box was made
    assert not later.of("error") and (tmp_path / "later.csv").stat().st_size > 0
    (tmp_path / "mine.npz").write_bytes((STAGE / "plate.modal.npz").read_bytes())
    assert not run([load("modal_impact~"), f"patcher {tmp_path}/a.maxpat{where}", "new b modal_impact~",
                    "send b 0 load mine.npz -sync"]).of("error")


def test_arrays_are_buffers():
    result = run([load("phantom"), *(f"buffer {name} 1 64 constant 0" for name in ("bx", "by", "bz")), "new b phantom",
                  "send b 0 path array bx by bz 500.", "send b 0 path array bx by no-such-buffer 500.", "advance 20"])
    errors = result.of("error")
    assert len(errors) == 1 and "no-such-buffer" in errors[0], errors
    # Of several channels the first: the hand follows the same numbers along x and y, and 5 mm of 100 along z.
    hand = run([load("phantom"), "buffer bx 1 480 sine 100 20", "buffer by 2 480 sine 100 20", "buffer bz 1 480 constant 5",
                "new b phantom", "send b 0 path array bx by bz 100.", "advance 1000"])
    x, y, z = ([float(words[1]) for _, _, words in hand.sent("b", outlet)] for outlet in range(3))
    assert all(words[0] == "float" and len(words) == 2 for outlet in range(3) for _, _, words in hand.sent("b", outlet))
    assert x == y and max(x) - min(x) > 0.01 and abs(z[-1] - 0.55) < 0.01, (x[-1], y[-1], z[-1])


def test_externals_share_a_device_by_name():
    result = run([load("phantom"), load("phantom~"), *ON, "new a phantom -name arm", "new b phantom~ arm", "advance 300",
                  "new c phantom~ arm", "advance 300", "free a", "advance 300", "new d phantom -name arm", "advance 300",
                  "free b", "free d", "free c"])
    def status(box):
        return [words[1] for _, _, words in result.sent(box) if words[0] == "status"]
    assert status("b") == ["attached", "waiting", "attached"]
    assert any("another phantom~ already uses this phantom" in e for e in result.of("error"))
    two = run([load("phantom"), load("phantom~"), *ON, "new a phantom -name arm", "new d phantom -name arm",
               "new b phantom~ arm", "advance 300", "free d", "advance 300", "free b", "free a"])
    assert [words[1] for _, _, words in two.sent("b") if words[0] == "status"] == ["attached"]  # to the first


def test_a_refused_box_leaves_nothing():
    result = run([load("particle~"), load("greed~"), "new b particle~ -nonsense 1", "new c greed~ clarinet oboe",
                  "new d greed~ -gian 1", "new e particle~ -preset maraca -gain 3", "get e gain"])
    assert sum("could not be made" in e for e in result.of("error")) == 3, result.of("error")
    assert result.values("e") == {"gain": "3.0"}


def test_a_box_is_freed_while_its_worker_works():
    lines = [load("modal_impact~"), *ON, f"searchpath {STAGE}", "dsp on"]
    for i in range(20):
        lines += [f"new b{i} modal_impact~", f"send b{i} 0 load plate.modal.npz", f"run {i % 3}", f"free b{i}"]
    run([*lines, "advance 50"])


@pytest.mark.parametrize("state", ["locked", "unlocked"])
def test_a_file_is_loaded_when_it_is_dropped_onto_the_box(state, tmp_path):
    def played(name, file, *then):
        return run([load(name), *ON, f"new b {name}", "dsp on", f'drop b {state} "{file}"', *then, "run 10", "send b 0 dump"])
    ground = tmp_path / "my ground.txt"
    ground.write_bytes((STAGE / "surfaces" / "snow.txt").read_bytes())
    result = played("footstep~", ground)
    assert not result.of("error") and not result.of("refused")
    assert any("my ground.txt" in line for line in result.of("out")), result.lines
    wrong = played("footstep~", STAGE / "plate.modal.npz")
    assert "plate.modal.npz" in wrong.of("error")[0] and not wrong.of("refused")
    assert "plate.modal.npz" in played("greed~", STAGE / "plate.modal.npz").of("refused")[0]
    played("modal_impact~", STAGE / "plate.modal.npz", "wait loaded")
