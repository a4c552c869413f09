//! Whole missions, small ones.

use crosscut_detector::{Preset, Registry, Settings};
use crosscut_flight::FlightAnswer;
use crosscut_missions::{Flown, Setup, fly, read_journal};
use crosscut_navigate::planners;
use crosscut_simulator::{Agility, Plan, SceneRecorder, World, families};

fn mission(world: &World, planner: &str, agility: Agility, seed: u64, most_revolutions: u64) -> Flown {
    mission_with(Preset::Default, world, planner, agility, seed, most_revolutions)
}

fn mission_with(
    preset: Preset,
    world: &World,
    planner: &str,
    agility: Agility,
    seed: u64,
    most_revolutions: u64,
) -> Flown {
    let registry = Registry::standard();
    let config = Settings::new(preset).config(&registry).expect("the settings of a preset");
    let planner = *planners().iter().find(|kind| kind.name == planner).expect("a planner of that name");
    let setup = Setup { config: &config, registry: &registry, planner, agility, seed, past: &[] };
    fly(world, &setup, &mut |moment| moment.frame.revolution.seq < most_revolutions)
}

fn tee(seed: u64) -> World {
    let tee = families().iter().find(|family| family.name == "tee").expect("there is one");
    (tee.world)(seed)
}

#[test]
fn every_planner_visits_all_of_a_tee_and_comes_home() {
    for planner in planners() {
        let flown = mission(&tee(1), planner.name, Agility::default(), 1, 3000);
        assert!(flown.is_success(), "{}: {flown:?}", planner.name);
        assert!(flown.way_m < 1.25 * flown.depth_first_m, "{}: {} m", planner.name, flown.way_m);
        assert_eq!(flown.map.ways_not_taken(), 0);
    }
}

#[test]
fn a_method_without_a_confidence_explores_a_tee() {
    let flown = mission_with(Preset::Threshold, &tee(1), "nearest_frontier", Agility::default(), 1, 3000);
    assert!(flown.is_success(), "{flown:?}");
}

#[test]
fn the_same_seed_gives_the_same_mission() {
    let way = |seed| {
        let registry = Registry::standard();
        let config = Settings::new(Preset::Default).config(&registry).expect("the default settings");
        let setup = Setup {
            config: &config,
            registry: &registry,
            planner: planners()[0],
            agility: Agility::default(),
            seed,
            past: &[],
        };
        let mut poses = Vec::new();
        let flown = fly(&tee(2), &setup, &mut |moment| {
            poses.push((moment.true_pose, moment.step.command, FlightAnswer::of(moment.frame).pose));
            moment.frame.revolution.seq < 150
        });
        assert_eq!(flown.revolutions, 151);
        poses
    };
    let first = way(5);
    assert!(first == way(5), "the same seed");
    assert!(first != way(6), "another seed");
}

#[test]
fn crashes_of_a_vehicle_that_cannot_brake_count_across_an_interruption() {
    let (registry, world) = (Registry::standard(), tee(1));
    let config = Settings::new(Preset::Default).config(&registry).expect("the default settings");
    let agility = Agility { acceleration_m_s2: 0.15, ..Agility::default() };
    let setup = Setup { config: &config, registry: &registry, planner: planners()[1], agility, seed: 1, past: &[] };
    let mut past = Vec::new();
    let flown = fly(&world, &setup, &mut |moment| {
        past.push((moment.scene)());
        past.len() < 600
    });
    assert!(flown.crashes > 0 && !flown.is_success(), "{flown:?}");
    let replayed = fly(&world, &Setup { past: &past, ..setup }, &mut |moment| moment.frame.revolution.seq < 599);
    assert_eq!((replayed.crashes, replayed.revolutions), (flown.crashes, flown.revolutions));
}

#[test]
fn a_vehicle_that_cannot_get_on_ends_its_mission() {
    let agility = Agility { speed_max_m_s: 0.01, ..Agility::default() };
    let flown = mission(&tee(1), "nearest_frontier", agility, 1, 5000);
    assert!(flown.end.is_some() && !flown.is_success(), "{flown:?}");
}

#[test]
fn a_loop_of_a_plan_is_flown_through_and_left() {
    let plan = Plan::from_json(
        r#"{"nodes": [{"id": "portal", "x_m": 0, "y_m": 0}, {"id": 1, "x_m": 16, "y_m": 0}, {"id": 2, "x_m": 32, "y_m": 0}],
            "edges": [{"from": "portal", "to": 1, "width_m": 3}, {"from": 1, "to": 2, "width_m": 3, "via_m": [[16, 14], [32, 14]]},
                      {"from": 1, "to": 2, "width_m": 3}], "roughness_m": 0.05}"#,
    );
    let world = plan.and_then(|plan| plan.world(1)).expect("a world");
    let flown = mission(&world, "nearest_frontier", Agility::default(), 1, 3000);
    assert!(flown.is_success(), "{flown:?}");
    // A bend where no third way is belongs to the loop: of the plan's places only two are ends of ways.
    assert_eq!((flown.ways, flown.offline_is_exact), (2, true));
}

#[test]
fn a_passage_is_visited_on_both_sides_of_a_start_midway() {
    let plan = Plan::from_json(
        r#"{"nodes": [{"id": 0, "x_m": 0, "y_m": 0}, {"id": 1, "x_m": 25, "y_m": 0}, {"id": 2, "x_m": 45, "y_m": 0},
            {"id": 3, "x_m": 60, "y_m": 0}, {"id": 4, "x_m": 45, "y_m": 15}], "edges": [{"from": 0, "to": 1, "width_m": 4},
            {"from": 1, "to": 2, "width_m": 4}, {"from": 2, "to": 3, "width_m": 4}, {"from": 2, "to": 4, "width_m": 4}],
            "start": {"node": 1, "towards": 2}}"#,
    );
    let world = plan.and_then(|plan| plan.world(1)).expect("a world");
    let flown = mission(&world, "nearest_frontier", Agility::default(), 1, 4000);
    assert!(flown.is_success(), "{} of {} ways: {:?}", flown.ways_visited, flown.ways, flown.missed_m);
}

#[test]
fn of_junctions_eleven_metres_apart_none_is_passed_over() {
    let nodes = [(-20, 0), (0, 0), (11, 0), (22, 0), (40, 0), (0, -16), (11, 16), (22, -16)];
    let nodes = nodes.iter().enumerate().map(|(id, (x, y))| format!(r#"{{"id":{id},"x_m":{x},"y_m":{y}}}"#));
    let edges = [(0, 1), (1, 2), (2, 3), (3, 4), (1, 5), (2, 6), (3, 7)];
    let edges = edges.map(|(from, to)| format!(r#"{{"from":{from},"to":{to},"width_m":4.5}}"#)).join(",");
    let plan = format!(r#"{{"nodes":[{}],"edges":[{edges}]}}"#, nodes.collect::<Vec<_>>().join(","));
    let world = Plan::from_json(&plan).and_then(|plan| plan.world(1)).expect("a world");
    let flown = mission(&world, "nearest_frontier", Agility::default(), 1, 6000);
    assert!(flown.is_success(), "{} of {} ways: {:?}", flown.ways_visited, flown.ways, flown.missed_m);
}

#[test]
fn a_resumed_mission_knows_all_that_it_knew() {
    let (registry, world) = (Registry::standard(), tee(3));
    let config = Settings::new(Preset::Default).config(&registry).expect("the default settings");
    let path = tempfile::NamedTempFile::new().expect("a temporary file");
    let setup = Setup {
        config: &config,
        registry: &registry,
        planner: planners()[0],
        agility: Agility::default(),
        seed: 3,
        past: &[],
    };
    let mut recorder = SceneRecorder::create(path.path()).expect("a file");
    let mut known = Vec::new();
    fly(&world, &setup, &mut |moment| {
        recorder.add(&(moment.scene)()).expect("written");
        known.push((FlightAnswer::of(moment.frame).pose, moment.step.command, moment.step.goal_m, moment.mapper.map()));
        known.len() < 200
    });
    recorder.finish().expect("written");
    let past = read_journal(path.path()).expect("read");
    assert_eq!(past.len(), 200);

    let mut again = Vec::new();
    let mut jump_m = None;
    let mut last_m = None;
    let flown = fly(&world, &Setup { past: &past, ..setup }, &mut |moment| {
        let at_m = moment.true_pose.position_m;
        if again.len() < known.len() {
            again.push((
                FlightAnswer::of(moment.frame).pose,
                moment.step.command,
                moment.step.goal_m,
                moment.mapper.map(),
            ));
            last_m = Some(at_m);
        } else if jump_m.is_none() {
            jump_m = last_m.map(|last_m| (at_m - last_m).norm());
        }
        true
    });
    assert!(again == known, "the same poses, commands and maps, to the last bit");
    assert!(jump_m.is_some_and(|jump_m| jump_m < 0.05), "it goes on from rest where it was: {jump_m:?}");
    assert!(flown.is_success() && flown.revolutions > 200, "{flown:?}");
}
